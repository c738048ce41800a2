// SPDX-License-Identifier: MIT
// What a control loop calls, of every observer: step() once a sample, with the outputs y, and with the inputs u where
// the model knows them. observer_core.h has what happens then.
#pragma once

#include <limits>

#include "nlo/observer_core.h"

namespace nlo {

/// All outputs are measured. A model that computes some of the others, its last outputs, has a type in this place whose
/// fill(readings) does.
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
  static constexpr int kMeasured = kNy - kComputed<Model>;  ///< outputs that step() takes
  using Output = Vector<Scalar, kMeasured>;
  using Input = Vector<Scalar, kDriven ? kNu : 1>;

  using Core::Core;
  using Core::reset;

  /// Starts from a given latent state, e.g. from T(x) of a known x. Refused (false, nothing changed) as restore() does.
  [[nodiscard]] constexpr bool reset(const Latent& z0, const Output& y0) requires(!Core::kReadsInputs) {
    return reset_to(z0, y0, {});
  }
  [[nodiscard]] constexpr bool reset(const Latent& z0, const Output& y0, const Input& u0) requires(Core::kReadsInputs) {
    return reset_to(z0, y0, u0);
  }

  /// Starts from the steady state of y (and u), z = z(0) + S y: a shorter transient when the plant is at rest,
  /// or after a gap.
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

  /// One sample period on, with the measurement at its end. The first measurement after a reset only starts the
  /// observer. A measurement that is not finite stands for a missed one.
  [[nodiscard]] constexpr StepStatus step(const Output& y) requires(!kDriven) { return take<true>(y, {}, Scalar(0)); }
  [[nodiscard]] constexpr StepStatus step(Scalar y) requires(kMeasured == 1 && !kDriven) { return step(Output{{y}}); }

  /// The same over dt seconds: for jitter, and after missed samples. Beyond 1.5 sample periods the step has the status
  /// of round(dt / period) - 1 missed samples (kHeld, or kStale), and so has each channel. The measurement is used all
  /// the same, and the next step of one sample period counts from 0.
  [[nodiscard]] constexpr StepStatus step(const Output& y, Scalar dt_s) requires(!kDriven) {
    return take<false>(y, {}, dt_s);
  }
  [[nodiscard]] constexpr StepStatus step(Scalar y, Scalar dt_s) requires(kMeasured == 1 && !kDriven) {
    return step(Output{{y}}, dt_s);
  }

  /// One sample period on, with the measurement at its end and the input u that the model's hold speaks of. An input
  /// that is not finite holds the last good one.
  [[nodiscard]] constexpr StepStatus step(const Output& y, const Input& u) requires kDriven {
    return take<true>(y, u, Scalar(0));
  }
  [[nodiscard]] constexpr StepStatus step(Scalar y, Scalar u) requires(kMeasured == 1 && kNu == 1) {
    return step(Output{{y}}, Input{{u}});
  }
  [[nodiscard]] constexpr StepStatus step(const Output& y, const Input& u, Scalar dt_s) requires kDriven {
    return take<false>(y, u, dt_s);
  }
  [[nodiscard]] constexpr StepStatus step(Scalar y, Scalar u, Scalar dt_s) requires(kMeasured == 1 && kNu == 1) {
    return step(Output{{y}}, Input{{u}}, dt_s);
  }

  /// One sample period on without a measurement: the last good one is held.
  [[nodiscard]] constexpr StepStatus step_missed() requires(!kDriven) { return step(missed()); }
  [[nodiscard]] constexpr StepStatus step_missed(const Input& u) requires kDriven { return step(missed(), u); }

 private:
  static constexpr Output missed() {
    Output y{};
    for (Scalar& entry : y) entry = std::numeric_limits<Scalar>::quiet_NaN();
    return y;
  }

  /// [y; u], with the outputs that are computed.
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

}  // namespace nlo
