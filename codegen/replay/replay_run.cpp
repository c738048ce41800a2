// SPDX-License-Identifier: MIT
#include "codegen/replay/replay_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "codegen/base/error.h"
#include "codegen/model/domain.h"
#include "codegen/structures/structure_module.h"

namespace nlo::codegen {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Returns the model with its folded networks, as it is exported.
Model as_exported(Model m, const FoldedModel& folded) {
  std::size_t next = 0;
  for (const Named<Network>& n : networks(m)) *n.network = unfolded(folded.networks[next++], n.network->inputs());
  return m;
}

ReplayRun run_at(double amplitude, bool follows_equations, const Model& m, const FoldedModel& folded,
                 const QuantisedModel* quantised, const ExportOptions& options) {
  ReplayRun run;
  run.inputs =
      replay_inputs(m, folded.stale_after, options.seed, options.samples, amplitude, {}, true, follows_equations);
  if (options.scalar != ScalarType::kDouble) {  // both sides get exactly the same measurements
    run.inputs.dt_s = run.inputs.dt_s.cast<float>().cast<double>().eval();
    run.inputs.outputs = run.inputs.outputs.cast<float>().cast<double>().eval();
    run.inputs.inputs = run.inputs.inputs.cast<float>().cast<double>().eval();
  }
  ReferenceObserver<double> exact(m);
  ExportedObserver exported(m, folded, quantised, options.scalar);
  const InputBox box = options.scalar == ScalarType::kInt16 ? input_box(m, folded) : InputBox{};
  const Eigen::Index samples = run.inputs.dt_s.size();
  run.z = run.exported_z = MatrixXd(m.nz(), samples);
  run.x_hat = run.exported_x_hat = MatrixXd(m.nx(), samples);
  if (folded.error) run.sigma = run.exported_sigma = MatrixXd(m.nx(), samples);
  for (Eigen::Index k = 0; k < samples; ++k) {
    const VectorXd y = run.inputs.outputs.col(k), u = run.inputs.inputs.col(k);
    const double dt_s = run.inputs.dt_s(k) == 0.0 ? m.sample_period_s : run.inputs.dt_s(k);
    exact.step(y, u, dt_s);
    exported.step(y, u, dt_s);
    const VectorXd turned = turns_in(m, exact.output());
    const VectorXd back = folded.steady_gain * turned;
    run.z.col(k) = exact.latent() - back;
    run.x_hat.col(k) = exact.estimate();
    if (options.scalar == ScalarType::kInt16) {
      const VectorXd nearest = run.z.col(k).cwiseMax(box.min.head(m.nz())).cwiseMin(box.max.head(m.nz()));
      run.x_hat.col(k) = exact.estimates(nearest, exact.output() - turned);
    }
    if (folded.error) {
      run.sigma.col(k) = exact.deviations(exact.latent(), exact.output(), {exact.error_is_known()});
      run.exported_sigma.col(k) =
          exported.deviation(exported.latent() - back, exact.output() - turned, exact.error_is_known());
    }
    run.status.push_back(exact.status());
    run.in_domain.push_back(exact.in_domain());
    run.exported_z.col(k) = exported.latent() - back;
    run.exported_x_hat.col(k) = exported.estimate(run.exported_z.col(k), exact.output() - turned);
  }
  return run;
}

/// Returns the largest difference between exported and exact estimates, relative to the largest exact one, over states.
double largest_difference(const ReplayRun& run) {
  const VectorXd off = (run.exported_x_hat - run.x_hat).cwiseAbs().rowwise().maxCoeff();
  return off.cwiseQuotient(run.x_hat.cwiseAbs().rowwise().maxCoeff().cwiseMax(1e-30)).maxCoeff();
}

std::variant<ReferenceObserver<float>, ReferenceObserver<double>> rounded_observer(const Model& exported,
                                                                                   const FlownRanges& ranges,
                                                                                   const QuantisedModel* quantised,
                                                                                   ScalarType scalar) {
  if (scalar == ScalarType::kDouble) return ReferenceObserver<double>(exported, Activations::kRuntime, ranges);
  return ReferenceObserver<float>(exported, Activations::kRuntime, ranges, quantised);
}

}  // namespace

VectorXd turns_in(const Model& m, const VectorXd& y) {
  VectorXd turned = VectorXd::Zero(m.nr());
  for (int j = 0; j < m.ny(); ++j) {
    const double wrap = m.outputs[static_cast<std::size_t>(j)].wrap;
    if (wrap > 0.0) turned(j) = wrap * std::round(y(j) / wrap);
  }
  return turned;
}

ExportedObserver::ExportedObserver(const Model& m, const FoldedModel& folded, const QuantisedModel* quantised,
                                   ScalarType scalar)
    : observer_(rounded_observer(as_exported(m, folded), folded.ranges, quantised, scalar)), quantised_(quantised) {}

void ExportedObserver::reset() {
  std::visit([](auto& observer) { observer.reset(); }, observer_);
}

void ExportedObserver::step(const VectorXd& y, const VectorXd& u, double dt_s) {
  std::visit([&](auto& observer) { observer.step(y, u, dt_s); }, observer_);
}

VectorXd ExportedObserver::latent() const {
  return std::visit([](const auto& observer) -> VectorXd { return observer.latent().template cast<double>(); },
                    observer_);
}

VectorXd ExportedObserver::estimate(const VectorXd& z, const VectorXd& y) const {
  if (!quantised_)
    return std::visit([&](const auto& observer) -> VectorXd { return observer.estimates(z, y); }, observer_);
  Eigen::VectorXf in(quantised_->map.inputs());
  in.head(z.size()) = z.cast<float>();
  if (in.size() > z.size()) in.tail(y.size()) = y.cast<float>();
  return evaluate(quantised_->map, in).cast<double>();
}

VectorXd ExportedObserver::deviation(const VectorXd& z, const VectorXd& y, bool known) const {
  return std::visit([&](const auto& observer) -> VectorXd { return observer.deviations(z, y, {known}); }, observer_);
}

MatrixXd ExportedObserver::estimates(const MatrixXd& z, const MatrixXd& y) const {
  if (!quantised_)
    return std::visit([&](const auto& observer) -> MatrixXd { return observer.estimates(z, y); }, observer_);
  MatrixXd x_hat(quantised_->map.outputs(), z.cols());
  for (Eigen::Index k = 0; k < z.cols(); ++k) x_hat.col(k) = estimate(z.col(k), y.col(k));
  return x_hat;
}

ReplayRun run_replay(const Model& m, const FoldedModel& folded, const QuantisedModel* quantised,
                     const ExportOptions& options) {
  constexpr int kFewestSamples = 20, kMostSamples = 1000000;
  if (options.samples < kFewestSamples || options.samples > kMostSamples)
    throw Error(
        fmt::format("{} replay samples are requested; choose {} to {}", options.samples, kFewestSamples, kMostSamples));
  const auto run_with = [&](bool follows_equations) {
    constexpr double kSmallest = 1.0 / 64.0;
    for (double amplitude = 1.0;; amplitude /= 2.0) {
      ReplayRun run = run_at(amplitude, follows_equations, m, folded, quantised, options);
      const auto inside = std::count(run.in_domain.begin(), run.in_domain.end(), true);
      if (2 * inside >= options.samples || amplitude <= kSmallest) return run;
    }
  };
  ReplayRun run = run_with(false);
  if (!module_of(m).has_known_equations()) return run;
  // A filter for a state far from its sensors amplifies readings that its plant cannot produce. Float and double then
  // drift apart, and a replay with their difference as its tolerance would accept a wrong export.
  constexpr double kMuchLess = 0.1;
  ReplayRun of_plant = run_with(true);
  return largest_difference(of_plant) < kMuchLess * largest_difference(run) ? of_plant : run;
}

}  // namespace nlo::codegen
