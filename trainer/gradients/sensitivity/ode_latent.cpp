// SPDX-License-Identifier: MIT
#include "trainer/gradients/sensitivity/ode_latent.h"

#include <array>
#include <cstddef>
#include <vector>

namespace nlo::trainer {

namespace {

/// Values of some rows for eight trajectories.
template <class Scalar>
using Lanes = std::vector<Scalar>;

template <class Scalar>
Lanes<Scalar> lanes(int rows) {
  return Lanes<Scalar>(static_cast<std::size_t>(rows) * kGroup);
}

/// One step of a run: its start, its length and the outputs within it.
template <class Scalar>
class Step {
 public:
  Step(const OdeRun<Scalar>& run, int rows, int outputs) : run_(run), rows_(rows), outputs_(outputs) {}

  void at(int k) {
    k_ = k;
    for (int l = 0; l < kGroup; ++l)
      h_[static_cast<std::size_t>(l)] = run_.uniform ? *run_.steps_s : run_.steps_s[k * kGroup + l];
  }

  const Scalar* h() const { return h_.data(); }

  void latent(int k, Scalar* z) const { gather(run_.latent, rows_, k, z); }
  void cotangent(int k, Scalar* p) const { gather(run_.cotangent, rows_, k, p); }
  void store(int k, const Scalar* z) const {
    for (int r = 0; r < rows_; ++r) std::copy_n(z + r * kGroup, kGroup, run_.latent + offset(r, k));
  }

  /// Computes the readings at the fraction c of the step.
  void output(double c, Scalar* y) const {
    const auto ramp = static_cast<Scalar>(run_.hold == Hold::kZeroOrder ? 0.0 : c);
    for (int j = 0; j < outputs_; ++j) {
      const Scalar* to = run_.readings + offset(j, k_ + 1);
      const Scalar* from = j >= run_.commands_from ? to : run_.readings + offset(j, k_);
      for (int l = 0; l < kGroup; ++l) y[j * kGroup + l] = from[l] + ramp * (to[l] - from[l]);
    }
  }

 private:
  std::ptrdiff_t offset(int row, int time) const {
    return (static_cast<std::ptrdiff_t>(row) * run_.length + time) * kGroup;
  }
  void gather(const Scalar* from, int rows, int k, Scalar* to) const {
    for (int r = 0; r < rows; ++r) std::copy_n(from + offset(r, k), kGroup, to + r * kGroup);
  }

  const OdeRun<Scalar>& run_;
  int rows_, outputs_;
  int k_ = 0;
  std::array<Scalar, kGroup> h_{};
};

/// Adds factor h x to `to`, lane by lane.
template <class Scalar>
void add_scaled(Lanes<Scalar>& to, double factor, const Scalar* h, const Lanes<Scalar>& x) {
  if (factor == 0.0) return;
  const auto f = static_cast<Scalar>(factor);
  for (std::size_t i = 0; i < to.size(); i += kGroup) {
    for (std::size_t l = 0; l < kGroup; ++l) to[i + l] += f * h[l] * x[i + l];
  }
}

/// Computes the stages of one step from z. Slot i of the dynamics then holds stage i.
template <class Scalar>
class Stages {
 public:
  Stages(OdeDynamics<Scalar>& dynamics, const RungeKutta& method)
      : dynamics_(dynamics),
        method_(method),
        at_(lanes<Scalar>(dynamics.rows())),
        y_(lanes<Scalar>(dynamics.readings())) {
    for (auto& slope : slopes_) slope = lanes<Scalar>(dynamics.rows());
  }

  void run(const Step<Scalar>& step, const Lanes<Scalar>& z) {
    for (int i = 0; i < method_.stages(); ++i) {
      at_ = z;
      for (int j = 0; j < i; ++j) add_scaled(at_, method_.a(i, j), step.h(), slopes_[static_cast<std::size_t>(j)]);
      step.output(method_.c(i), y_.data());
      dynamics_.derivative(i, at_.data(), y_.data(), slopes_[static_cast<std::size_t>(i)].data());
    }
  }

  /// Computes z+ = z + h sum_i b_i k_i.
  void advance(const Step<Scalar>& step, Lanes<Scalar>& z) const {
    for (int i = 0; i < method_.stages(); ++i)
      add_scaled(z, method_.b(i), step.h(), slopes_[static_cast<std::size_t>(i)]);
  }

 private:
  OdeDynamics<Scalar>& dynamics_;
  RungeKutta method_;
  Lanes<Scalar> at_, y_;
  std::array<Lanes<Scalar>, RungeKutta::kMostStages> slopes_;
};

}  // namespace

template <class Scalar>
void integrate(OdeDynamics<Scalar>& dynamics, const RungeKutta& method, const OdeRun<Scalar>& run) {
  Step<Scalar> step(run, dynamics.rows(), dynamics.readings());
  Stages<Scalar> stages(dynamics, method);
  Lanes<Scalar> z = lanes<Scalar>(dynamics.rows());
  dynamics.start(z.data());
  for (int k = 0;; ++k) {
    step.store(k, z.data());
    if (k + 1 >= run.length) return;
    step.at(k);
    stages.run(step, z);
    stages.advance(step, z);
  }
}

template <class Scalar>
void backprop(OdeDynamics<Scalar>& dynamics, const RungeKutta& method, const OdeRun<Scalar>& run) {
  Step<Scalar> step(run, dynamics.rows(), dynamics.readings());
  Stages<Scalar> stages(dynamics, method);
  Lanes<Scalar> z = lanes<Scalar>(dynamics.rows()), p = z, pulled = z, at_sample = z;
  std::array<Lanes<Scalar>, RungeKutta::kMostStages> slope_cotangents;
  step.cotangent(run.length - 1, p.data());
  for (int k = run.length - 2; k >= 0; --k) {
    step.at(k);
    step.latent(k, z.data());
    stages.run(step, z);
    for (int i = 0; i < method.stages(); ++i) {
      Lanes<Scalar>& cotangent = slope_cotangents[static_cast<std::size_t>(i)];
      cotangent.assign(p.size(), Scalar(0));
      add_scaled(cotangent, method.b(i), step.h(), p);
    }
    for (int i = method.stages() - 1; i >= 0; --i) {
      dynamics.pull_back(i, slope_cotangents[static_cast<std::size_t>(i)].data(), pulled.data());
      for (std::size_t n = 0; n < p.size(); ++n) p[n] += pulled[n];
      for (int j = 0; j < i; ++j)
        add_scaled(slope_cotangents[static_cast<std::size_t>(j)], method.a(i, j), step.h(), pulled);
    }
    step.cotangent(k, at_sample.data());
    for (std::size_t n = 0; n < p.size(); ++n) p[n] += at_sample[n];
  }
}

template <class Scalar>
void adjoint(OdeDynamics<Scalar>& dynamics, const OdeRun<Scalar>& run) {
  constexpr int kEnd = 0, kMiddle = 1, kBegin = 2;  // slots at which dF/dz is evaluated
  Step<Scalar> step(run, dynamics.rows(), dynamics.readings());
  const std::size_t size = static_cast<std::size_t>(dynamics.rows()) * kGroup;
  Lanes<Scalar> y = lanes<Scalar>(dynamics.readings());
  Lanes<Scalar> begin(size), end(size), middle(size), slope_begin(size), slope_end(size), unused(size);
  Lanes<Scalar> p(size), stage(size), pulled(size), next(size), at_sample(size);
  step.cotangent(run.length - 1, p.data());
  for (int k = run.length - 2; k >= 0; --k) {
    step.at(k);
    const Scalar* h = step.h();
    step.latent(k, begin.data());
    step.latent(k + 1, end.data());
    step.output(1.0, y.data());
    dynamics.derivative(kEnd, end.data(), y.data(), slope_end.data());
    step.output(0.0, y.data());
    dynamics.derivative(kBegin, begin.data(), y.data(), slope_begin.data());
    for (std::size_t n = 0; n < size; ++n) {
      middle[n] = Scalar(0.5) * (begin[n] + end[n]) + Scalar(0.125) * h[n % kGroup] * (slope_begin[n] - slope_end[n]);
    }
    step.output(0.5, y.data());
    dynamics.derivative(kMiddle, middle.data(), y.data(), unused.data());

    // Backward in time p grows by (dF/dz)^T p. pull_back() is linear in its cotangent: if a stage's cotangent is scaled
    // by its weight in the step, the stage also adds its part of mu with this weight.
    next = p;
    stage = p;
    const int slots[] = {kEnd, kMiddle, kMiddle, kBegin};
    const RungeKutta rk4 = kRk4<double>;
    for (int i = 0; i < 4; ++i) {
      const auto share = static_cast<Scalar>(rk4.b(i));
      for (std::size_t n = 0; n < size; ++n) stage[n] *= share * h[n % kGroup];
      dynamics.pull_back(slots[i], stage.data(), pulled.data());
      for (std::size_t n = 0; n < size; ++n) next[n] += pulled[n];
      if (i == 3) break;
      const auto reach = static_cast<Scalar>(rk4.a(i + 1, i) / rk4.b(i));
      for (std::size_t n = 0; n < size; ++n) stage[n] = p[n] + reach * pulled[n];
    }
    step.cotangent(k, at_sample.data());
    for (std::size_t n = 0; n < size; ++n) p[n] = next[n] + at_sample[n];
  }
}

template void integrate(OdeDynamics<float>&, const RungeKutta&, const OdeRun<float>&);
template void integrate(OdeDynamics<double>&, const RungeKutta&, const OdeRun<double>&);
template void backprop(OdeDynamics<float>&, const RungeKutta&, const OdeRun<float>&);
template void backprop(OdeDynamics<double>&, const RungeKutta&, const OdeRun<double>&);
template void adjoint(OdeDynamics<float>&, const OdeRun<float>&);
template void adjoint(OdeDynamics<double>&, const OdeRun<double>&);

}  // namespace nlo::trainer
