// SPDX-License-Identifier: MIT
#include "trainer/gradients/sensitivity/latent_dynamics.h"

#include <utility>

namespace nlo::trainer {

LinearLatent::LinearLatent(LatentShape shape, std::vector<double> eigenvalues, const std::vector<double>& steps_s,
                           bool fixed)
    : LatentDynamics(shape.rows),
      shape_(std::move(shape)),
      eigenvalues_(std::move(eigenvalues)),
      steps_s_(steps_s),
      fixed_(fixed) {}

void LinearLatent::prepare(const float* parameters) {
  if (fixed_ && prepared_) return;
  eigenvalues_from_parameters(shape_, parameters, eigenvalues_.data());
  coefficients_.compute(shape_, eigenvalues_.data(), steps_s_);
  prepared_ = true;
}

void LinearLatent::forward(SegmentGroup& group, int /*thread*/) {
  filter(shape_, coefficients_, group);
}

void LinearLatent::backward(SegmentGroup& group, int /*thread*/) {
  adjoint_filter(shape_, coefficients_, eigenvalues_.data(), group);
}

OdeLatent::OdeLatent(const Factory& make, int threads, const LatentShape& shape, LatentGradient gradient,
                     const std::vector<double>& steps_s)
    : LatentDynamics(make()->rows()),
      hold_(shape.hold),
      commands_from_(shape.commands_from),
      by_adjoint_(gradient == LatentGradient::kAdjoint),
      steps_s_(steps_s),
      step_s_(static_cast<float>(steps_s.front())) {
  for (int t = 0; t < threads; ++t) dynamics_.push_back(make());
}

void OdeLatent::prepare(const float* parameters) {
  const auto count = static_cast<std::size_t>(dynamics_.front()->parameters());
  parameters_.assign(parameters, parameters + count);
  for (auto& dynamics : dynamics_) dynamics->prepare(parameters_.data());
}

OdeRun<float> OdeLatent::run_of(SegmentGroup& group, std::vector<float>& steps) const {
  OdeRun<float> run{.length = group.length,
                    .hold = hold_,
                    .readings = group.readings.data(),
                    .steps_s = &step_s_,
                    .uniform = group.step_of.empty(),
                    .latent = group.latent.data(),
                    .cotangent = group.cotangent.data(),
                    .commands_from = commands_from_};
  if (!run.uniform) {
    for (const int step : group.step_of) steps.push_back(static_cast<float>(steps_s_[static_cast<std::size_t>(step)]));
    run.steps_s = steps.data();
  }
  return run;
}

void OdeLatent::forward(SegmentGroup& group, int thread) {
  std::vector<float> steps;
  integrate(*dynamics_[static_cast<std::size_t>(thread)], kRk4<double>, run_of(group, steps));
}

void OdeLatent::backward(SegmentGroup& group, int thread) {
  OdeDynamics<float>& dynamics = *dynamics_[static_cast<std::size_t>(thread)];
  dynamics.clear_gradient();
  std::vector<float> steps;
  if (by_adjoint_) {
    adjoint(dynamics, run_of(group, steps));
  } else {
    backprop(dynamics, kRk4<double>, run_of(group, steps));
  }
  std::vector<float> gradient(static_cast<std::size_t>(dynamics.parameters()));
  dynamics.gradient(gradient.data());
  group.gradient.assign(gradient.begin(), gradient.end());
}

}  // namespace nlo::trainer
