// SPDX-License-Identifier: MIT
// What all observers share: an observer is a model (a constant, in flash) and a state (RAM) that each sample takes on
// by one step. Measurements are screened, faults held and counted, angles turned back; the model's equations are its
// own.
//
// No heap, no exceptions, no libm; whatever arrives, z stays finite.
#pragma once

#include <cstdint>
#include <limits>

#include "nlo/arithmetic.h"
#include "nlo/measurement.h"
#include "nlo/select.h"
#include "nlo/simd.h"
#include "nlo/vector.h"

namespace nlo {

/// The inputs of the last sample; nothing where a model has none.
template <class Scalar, int kNu>
struct InputMemory {
  Scalar u[kNu];
};
template <class Scalar>
struct InputMemory<Scalar, 0> {};

/// Steps a model, which has
///   Scalar, kNx, kNy, kNz, kNu         sizes; kNu = 0 unless the plant's inputs are known
///   kLongestGap                        sample periods that one step may span
///   kHasSteadyState                    z settles at S y: `latent` has steady_gain S and starts_steady
///   kMayDiverge                        stability is not proven: each step is checked
///   sample_period_s, stale_after, outputs, domain
///   initial_latent()                   z before the first measurement
///   advance(z, y, y_next[, u, u_next], dt_s)   z one step on, in place; dt_s = 0: one sample period
///   estimate(z, y, x_hat)
/// For the deterministic policy the last two are templates on the policy too.
template <class Model_, Arithmetic kArithmetic_ = Arithmetic::kFast>
class SampledObserver {
 public:
  using Model = Model_;
  using Scalar = typename Model::Scalar;
  static constexpr Arithmetic kArithmetic = kArithmetic_;
  static constexpr int kNx = Model::kNx;
  static constexpr int kNy = Model::kNy;
  static constexpr int kNz = Model::kNz;
  static constexpr int kNu = Model::kNu;
  static constexpr bool kDriven = kNu > 0;
  /// The deterministic policy also takes the same number of instructions for every measurement, once started and at the
  /// sample period.
  static constexpr bool kEven = kArithmetic == Arithmetic::kDeterministic;
  using Output = Vector<Scalar, kNy>;
  using Input = Vector<Scalar, kDriven ? kNu : 1>;
  using Latent = Vector<Scalar, kNz>;
  using Estimate = Vector<Scalar, kNx>;

  /// All that changes; save() and restore() carry it over a restart.
  struct State {
    Scalar z[kNz];
    Scalar y[kNy];                                         ///< last good output
    [[no_unique_address]] InputMemory<Scalar, kNu> input;  ///< last good input
    std::uint16_t held;                                    ///< measurements held in a row
    StepStatus status;
    std::uint8_t started;  ///< 1 once a first measurement has come; no bool: storage may hand back any byte
  };

  /// The model must outlive the observer; generated models are constants.
  constexpr explicit SampledObserver(const Model& model) : model_(&model) { reset(); }
  explicit SampledObserver(const Model&&) = delete;

  /// Forgets everything: z = z(0), waiting for the first measurement.
  constexpr void reset() {
    state_ = State{};
    for (int r = 0; r < kNz; ++r) state_.z[r] = model_->initial_latent()[r];
  }

  /// Starts from a given latent state, e.g. from T(x) of a known x. Refused (false, nothing changed) as restore() does.
  [[nodiscard]] constexpr bool reset(const Latent& z0, const Output& y0) {
    State next{};
    for (int r = 0; r < kNz; ++r) next.z[r] = z0[r];
    for (int j = 0; j < kNy; ++j) next.y[j] = y0[j];
    next.started = 1;
    return restore(next);
  }

  /// Starts from the steady state of y, z = z(0) + S y: a shorter transient when the plant is at rest, or after a gap.
  [[nodiscard]] constexpr StepStatus warm_start(const Output& y) requires(Model::kHasSteadyState) {
    Scalar accepted[kNy]{};
    for (int j = 0; j < kNy; ++j) accepted[j] = state_.y[j];
    const StepStatus screened = model_->outputs.screen(y, accepted);
    if (screened == StepStatus::kHeld) return state_.status = note_held(state_.held, model_->stale_after);
    reset();
    start(accepted, true);
    return state_.status = screened;
  }
  [[nodiscard]] constexpr StepStatus warm_start(Scalar y) requires(Model::kHasSteadyState&& kNy == 1) {
    return warm_start(Output{{y}});
  }

  /// One sample period on, with the measurement at its end. The first measurement after a reset only starts the
  /// observer. A measurement that is not finite stands for a missed one.
  [[nodiscard]] constexpr StepStatus step(const Output& y) requires(!kDriven) {
    return step_by<true>(y, {}, Scalar(0));
  }

  /// The same over dt seconds: for jitter, and for what comes after missed samples.
  [[nodiscard]] constexpr StepStatus step(const Output& y, Scalar dt_s) requires(!kDriven) {
    return possible(dt_s) ? step_by<false>(y, {}, dt_s) : state_.status = StepStatus::kRejected;
  }
  [[nodiscard]] constexpr StepStatus step(Scalar y) requires(!kDriven && kNy == 1) { return step(Output{{y}}); }
  [[nodiscard]] constexpr StepStatus step(Scalar y, Scalar dt_s) requires(!kDriven && kNy == 1) {
    return step(Output{{y}}, dt_s);
  }

  /// One sample period on, with the measurement at its end and the input u that the model's hold speaks of. An input
  /// that is not finite holds the last good one.
  [[nodiscard]] constexpr StepStatus step(const Output& y, const Input& u) requires kDriven {
    return step_by<true>(y, u, Scalar(0));
  }
  [[nodiscard]] constexpr StepStatus step(const Output& y, const Input& u, Scalar dt_s) requires kDriven {
    return possible(dt_s) ? step_by<false>(y, u, dt_s) : state_.status = StepStatus::kRejected;
  }
  [[nodiscard]] constexpr StepStatus step(Scalar y, Scalar u) requires(kNy == 1 && kNu == 1) {
    return step(Output{{y}}, Input{{u}});
  }
  [[nodiscard]] constexpr StepStatus step(Scalar y, Scalar u, Scalar dt_s) requires(kNy == 1 && kNu == 1) {
    return step(Output{{y}}, Input{{u}}, dt_s);
  }

  /// One sample period on without a measurement: the last good one is held.
  [[nodiscard]] constexpr StepStatus step_missed() requires(!kDriven) { return step(missed()); }
  [[nodiscard]] constexpr StepStatus step_missed(const Input& u) requires kDriven { return step(missed(), u); }

  /// x_hat. Computed on each call; costs the multiply-adds of the model's inverse map.
  [[nodiscard]] Estimate estimate() const {
    Estimate x_hat;
    if constexpr (kArithmetic == Arithmetic::kFast) {
      model_->estimate(state_.z, state_.y, x_hat.values);
    } else {
      model_->template estimate<kArithmetic>(state_.z, state_.y, x_hat.values);
    }
    return x_hat;
  }

  [[nodiscard]] constexpr Latent latent() const {
    Latent z{};
    for (int r = 0; r < kNz; ++r) z[r] = state_.z[r];
    return z;
  }

  /// Status of the latest step.
  [[nodiscard]] constexpr StepStatus status() const { return state_.status; }

  /// z is where training has been. False tells that estimate() extrapolates.
  [[nodiscard]] constexpr bool in_domain() const {
    Scalar relative[kNz]{};
    for (int r = 0; r < kNz; ++r) {
      relative[r] = state_.z[r];
      if constexpr (Model::kHasSteadyState) {
        for (int j = 0; j < kNy; ++j) {
          if (!(model_->outputs.wrap[j] > Scalar(0)) && !model_->latent.relative[j]) continue;
          relative[r] -= rounded<Scalar>(model_->latent.steady_gain[r][j] * state_.y[j]);
        }
      }
    }
    return model_->domain.contains(relative);
  }

  [[nodiscard]] constexpr const Model& model() const { return *model_; }
  [[nodiscard]] constexpr State save() const { return state_; }

  /// Continues from a saved state. Refused (false, nothing changed) unless it is one that stepping can reach: z finite
  /// and not so large that a step overflows, y in its range, flags valid. What comes from storage may be damaged.
  [[nodiscard]] constexpr bool restore(const State& saved) {
    if (!reachable(saved.z) || saved.started > 1 || saved.status > StepStatus::kDiverged) return false;
    if constexpr (kDriven) {
      for (const Scalar u : saved.input.u) {
        if (!is_finite(u)) return false;
      }
    }
    if (saved.started == 1) {
      if (!model_->outputs.may_hold(saved.y)) return false;
    } else {
      for (const Scalar y : saved.y) {
        if (!(y == Scalar(0))) return false;
      }
    }
    state_ = saved;
    return true;
  }

 private:
  static constexpr Output missed() {
    Output y{};
    for (Scalar& entry : y) entry = std::numeric_limits<Scalar>::quiet_NaN();
    return y;
  }

  constexpr bool possible(Scalar dt_s) const {
    return is_finite(dt_s) && dt_s > Scalar(0) && dt_s <= Scalar(Model::kLongestGap) * model_->sample_period_s;
  }

  static constexpr bool reachable(const Scalar (&z)[kNz]) {
    constexpr Scalar kLargest = Scalar(0x1p100);
    bool good = true;
    for (const Scalar value : z) good = good && is_finite(value) && value >= -kLargest && value <= kLargest;
    return good;
  }

  constexpr void start(const Scalar (&y)[kNy], bool steady) {
    for (int j = 0; j < kNy; ++j) {
      const Scalar turn = model_->outputs.wrap[j];
      state_.y[j] = turn > Scalar(0) ? OutputRange<Scalar, kNy>::wrapped(y[j], turn) : y[j];
    }
    if constexpr (Model::kHasSteadyState) {
      for (int r = 0; steady && r < kNz; ++r) {
        for (int j = 0; j < kNy; ++j) state_.z[r] += rounded<Scalar>(model_->latent.steady_gain[r][j] * state_.y[j]);
      }
    }
    state_.started = 1;
  }

  /// kRegular: one sample period, dt_s does not matter, and nothing is compiled in that other steps need.
  template <bool kRegular>
  NLO_OWN_FRAME constexpr StepStatus step_by(const Output& y, const Input& u, Scalar dt_s) {
    Scalar next[kNy]{};
    for (int j = 0; j < kNy; ++j) next[j] = state_.y[j];
    StepStatus screened = kEven ? model_->outputs.screen_evenly(y, next) : model_->outputs.screen(y, next);
    InputMemory<Scalar, kNu> input = state_.input;
    if constexpr (kDriven) {
      for (int i = 0; i < kNu; ++i) {
        if (is_finite(u[i])) {
          input.u[i] = u[i];
        } else {
          screened = StepStatus::kHeld;
        }
      }
    }
    if constexpr (kEven) {
      state_.status = note_evenly(screened, state_.held, model_->stale_after);
    } else if (screened == StepStatus::kHeld) {
      state_.status = note_held(state_.held, model_->stale_after);
    } else {
      state_.held = 0;
      state_.status = screened;
    }
    if (state_.started == 0) {
      if (screened == StepStatus::kHeld) return state_.status;  // nothing to hold yet
      if constexpr (Model::kHasSteadyState) {
        start(next, model_->latent.starts_steady);
      } else {
        start(next, false);
      }
      state_.input = input;
      return state_.status;
    }
    advance(next, input, kRegular ? Scalar(0) : dt_s);
    state_.input = input;
    for (int j = 0; j < kNy; ++j) state_.y[j] = next[j];
    if constexpr (Model::kHasSteadyState) turn_back();
    return state_.status;
  }

  constexpr void advance(const Scalar (&y_next)[kNy], const InputMemory<Scalar, kNu>& input, Scalar dt_s) {
    Scalar z[kNz]{};
    for (int r = 0; r < kNz; ++r) z[r] = state_.z[r];
    if constexpr (kDriven) {
      static_assert(kArithmetic == Arithmetic::kFast, "driven observers know the fast arithmetic only");
      model_->advance(z, state_.y, y_next, state_.input.u, input.u, dt_s);
    } else if constexpr (kArithmetic == Arithmetic::kFast) {
      model_->advance(z, state_.y, y_next, dt_s);
    } else {
      model_->template advance<kArithmetic>(z, state_.y, y_next, dt_s);
    }
    if constexpr (Model::kMayDiverge) {
      if (!reachable(z)) {  // the last good z is kept: what follows may lead it back
        state_.status = StepStatus::kDiverged;
        return;
      }
    }
    // With zero input z would stay subnormal for ever, and subnormals are slow on some cores.
    constexpr Scalar kTiny = Scalar(0x1p-100);
    for (int r = 0; r < kNz; ++r) {
      if constexpr (kEven) {
        state_.z[r] = select((z[r] < kTiny) & (z[r] > -kTiny), Scalar(0), z[r]);
      } else {
        state_.z[r] = z[r] < kTiny && z[r] > -kTiny ? Scalar(0) : z[r];
      }
    }
  }

  /// An angle that has left its first turn goes back by whole turns, and z with it: S is the response to a constant,
  /// so the latent system does not notice. This keeps z bounded however often the shaft turns.
  constexpr void turn_back() {
    for (int j = 0; j < kNy; ++j) {
      const Scalar turn = model_->outputs.wrap[j];
      if (!(turn > Scalar(0))) continue;
      using Range = OutputRange<Scalar, kNy>;
      const Scalar turns = kEven ? Range::whole_turns_evenly(state_.y[j], turn) : Range::whole_turns(state_.y[j], turn);
      const Scalar back = rounded<Scalar>(turn * turns);
      if (!kEven && back == Scalar(0)) continue;  // taking away 0 changes nothing: z is never -0
      state_.y[j] -= back;
      for (int r = 0; r < kNz; ++r) state_.z[r] -= rounded<Scalar>(model_->latent.steady_gain[r][j] * back);
    }
  }

  const Model* model_;
  State state_{};
};

}  // namespace nlo
