// SPDX-License-Identifier: MIT
// The functions that a control loop calls: step() once per sample, with the outputs y and, if the model knows inputs,
// the inputs u. observer_core.h implements the step, and has estimate(), status() and in_domain().
#pragma once

#include <limits>

#include "nlo/observer_core.h"

namespace nlo::inline NLO_ISA {

/// Stands for a model whose outputs are all measured. A model that computes its last outputs from the measured ones has
/// a type with kCount and fill(readings) instead.
struct NoComputed {
  static constexpr int kCount = 0;
};

template <class Model>
inline constexpr int kComputed = [] {
  if constexpr (requires { typename Model::Computed; }) return Model::Computed::kCount;
  return 0;
}();

template <ObserverModel Model_, Arithmetic kArithmetic_ = Arithmetic::kFast>
class SampledObserver : public ObserverCore<Model_, kArithmetic_> {
 public:
  using Core = ObserverCore<Model_, kArithmetic_>;
  using Core::kDriven;
  using Core::kNr;
  using Core::kNu;
  using Core::kNy;
  using Core::kNz;
  using typename Core::Latent;
  using typename Core::Model;
  using typename Core::Scalar;
  using typename Core::State;
  static constexpr int kMeasured = kNy - kComputed<Model>;  ///< number of outputs that step() takes
  using Output = Vector<Scalar, kMeasured>;
  using Input = Vector<Scalar, kDriven ? kNu : 1>;

  using Core::Core;
  using Core::reset;

  /// Starts from a given latent state, e.g. T(x) of a known x. Returns false and changes nothing if steps cannot lead
  /// to that state.
  [[nodiscard]] constexpr bool reset(const Latent& z0, const Output& y0) requires(!Core::kReadsInputs) {
    return reset_to(z0, y0, {});
  }
  [[nodiscard]] constexpr bool reset(const Latent& z0, const Output& y0, const Input& u0) requires(Core::kReadsInputs) {
    return reset_to(z0, y0, u0);
  }

  /// Starts from the steady state of y (and u), z = z(0) + S y. This shortens the transient if the plant is at rest,
  /// also after a gap.
  [[nodiscard]] constexpr StepStatus warm_start(const Output& y) requires(Model::kHasSteadyState &&
                                                                          !Core::kReadsInputs) {
    return this->start_steady(readings(y, {}));
  }
  [[nodiscard]] constexpr StepStatus warm_start(const Output& y,
                                                const Input& u) requires(Model::kHasSteadyState&& Core::kReadsInputs) {
    return this->start_steady(readings(y, u));
  }
  [[nodiscard]] constexpr StepStatus warm_start(Scalar y) requires(kMeasured == 1 && Model::kHasSteadyState &&
                                                                   !Core::kReadsInputs) {
    return warm_start(Output{{y}});
  }

  /// Advances the observer by one sample period, with the measurement y at the end of it. The first measurement after a
  /// reset only starts the observer. A measurement that is not finite counts as missing.
  [[nodiscard]] constexpr StepStatus step(const Output& y) requires(!kDriven) { return take<true>(y, {}, Scalar(0)); }
  [[nodiscard]] constexpr StepStatus step(Scalar y) requires(kMeasured == 1 && !kDriven) { return step(Output{{y}}); }

  /// Advances the observer by dt_s seconds, for jitter and after missed samples. If dt_s is over 1.5 sample periods,
  /// the observer and each channel have the status of round(dt_s / period) - 1 missed samples (kHeld or kStale). The
  /// measurement is used nevertheless, and the next step of one sample period counts from 0 again.
  [[nodiscard]] constexpr StepStatus step(const Output& y, Scalar dt_s) requires(!kDriven) {
    return take<false>(y, {}, dt_s);
  }
  [[nodiscard]] constexpr StepStatus step(Scalar y, Scalar dt_s) requires(kMeasured == 1 && !kDriven) {
    return step(Output{{y}}, dt_s);
  }

  /// Advances the observer by one sample period, with the measurement y at the end of it. u: with input_hold
  /// "zero_order" the input that has acted since the last sample, else the input at the end. If an input is not finite,
  /// the last good one is held.
  [[nodiscard]] constexpr StepStatus step(const Output& y, const Input& u) requires kDriven {
    return take<true>(y, u, Scalar(0));
  }
  [[nodiscard]] constexpr StepStatus step(Scalar y, Scalar u) requires(kMeasured == 1 && kNu == 1) {
    return step(Output{{y}}, Input{{u}});
  }
  [[nodiscard]] constexpr StepStatus step(const Output& y, Scalar u) requires(kMeasured > 1 && kNu == 1) {
    return step(y, Input{{u}});
  }
  [[nodiscard]] constexpr StepStatus step(Scalar y, const Input& u) requires(kMeasured == 1 && kNu > 1) {
    return step(Output{{y}}, u);
  }
  [[nodiscard]] constexpr StepStatus step(const Output& y, const Input& u, Scalar dt_s) requires kDriven {
    return take<false>(y, u, dt_s);
  }
  [[nodiscard]] constexpr StepStatus step(Scalar y, Scalar u, Scalar dt_s) requires(kMeasured == 1 && kNu == 1) {
    return step(Output{{y}}, Input{{u}}, dt_s);
  }
  [[nodiscard]] constexpr StepStatus step(const Output& y, Scalar u, Scalar dt_s) requires(kMeasured > 1 && kNu == 1) {
    return step(y, Input{{u}}, dt_s);
  }
  [[nodiscard]] constexpr StepStatus step(Scalar y, const Input& u, Scalar dt_s) requires(kMeasured == 1 && kNu > 1) {
    return step(Output{{y}}, u, dt_s);
  }

  /// Advances the observer by one sample period without a measurement: the last good one is held.
  [[nodiscard]] constexpr StepStatus step_missed() requires(!kDriven) { return step(missed()); }
  [[nodiscard]] constexpr StepStatus step_missed(const Input& u) requires kDriven { return step(missed(), u); }

 private:
  static constexpr Output missed() {
    Output y{};
    for (Scalar& entry : y) entry = std::numeric_limits<Scalar>::quiet_NaN();
    return y;
  }

  /// Returns [y; u] with the computed outputs.
  static constexpr typename Core::Readings readings(const Output& y, const Input& u) {
    typename Core::Readings r{};
    for (int j = 0; j < kMeasured; ++j) r[j] = y[j];
    for (int i = 0; Core::kReadsInputs && i < kNu; ++i) r[kNy + i] = u[i];
    if constexpr (kMeasured < kNy) Model::Computed::fill(r.values);
    return r;
  }

  template <bool kRegular>
  constexpr StepStatus take(const Output& y, const Input& u, Scalar dt_s) {
    if constexpr (!kRegular) {
      if (!this->possible(dt_s)) return this->state_.status = StepStatus::kRejected;
    }
    if constexpr (kNr > kMeasured) {
      return this->template step_by<kRegular>(readings(y, u), {}, dt_s);
    } else {
      return this->template step_by<kRegular>(y, u, dt_s);
    }
  }

  constexpr bool reset_to(const Latent& z0, const Output& y0, const Input& u0) {
    State next{};
    for (int r = 0; r < kNz; ++r) next.z[r] = z0[r];
    const auto given = readings(y0, u0);
    for (int j = 0; j < kNr; ++j) next.y[j] = given[j];
    next.started = 1;
    return this->restore(next);
  }
};

}  // namespace nlo::inline NLO_ISA
