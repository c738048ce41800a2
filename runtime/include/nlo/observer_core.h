// SPDX-License-Identifier: MIT
// One step of any observer: validates a sample, counts faults (measurement.h), and advances the latent state z by the
// model's equations. The model is a constant (flash); the state is in RAM (observer_state.h). sampled_observer.h has
// the functions that a control loop calls.
//
// No heap, no exceptions, no libm. z stays finite for any input. If a bit flip corrupts z, the next step detects it and
// returns kReset.
#pragma once

#include <cstdint>

#include "nlo/acting_inputs.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"
#include "nlo/latent.h"
#include "nlo/measurement.h"
#include "nlo/observer_state.h"
#include "nlo/sensor_failures.h"
#include "nlo/steady_state.h"
#include "nlo/vector.h"

namespace nlo::inline NLO_ISA {

/// Compile-time constants of a model.
template <class M>
concept HasSizes = requires {
  typename M::Scalar;
  M::kNx;              // estimate
  M::kNy;              // outputs
  M::kNz;              // latent state
  M::kNu;              // known inputs of the plant
  M::kNf;              // outputs that may be missing
  M::kNr;              // readings, the values that F and T* read: [y] or [y; u], then the staleness of each kNf output
  M::kLongestGap;      // sample periods that one step may span
  M::kHasSteadyState;  // z settles at S y for constant y: `latent` has steady_gain S and starts_steady
  M::kMayDiverge;      // stability is not proven: every step is checked for overflow
};

/// Data members of a model.
template <class M>
concept HasValues = requires(const M& model) {
  model.sample_period_s;
  model.stale_after;
  model.outputs.min[M::kNr - 1];  // ReadingRange of all readings
  model.domain.latent_min[M::kNz - 1];
  model.initial_latent()[M::kNz - 1];  // z before the first measurement
};

/// Equations of a model. `y` holds all readings.
///   advance(z, y, y_next, dt_s)             advances z in place over dt_s seconds; 0: one sample period
///   advance(z, y, y_next, u, u_next, dt_s)  the same for inputs that are not readings (acting_inputs.h)
///   advance(z, y, y_next, arrived, dt_s)    the same for a model with kReadsArrivals: arrived[j], n_y, is false if
///                                           output j was not measured and y_next holds its last value
///   estimate(z, y, x_hat)                   x_hat = T*(z, y)
///   start(y, z)                             optional: sets z at the first measurement, after z = initial + S y
///   start(y, arrived, z)                    the same for a model with kReadsArrivals
/// A model for the deterministic policy, or with inputs that are not readings, defines them as templates on the policy.
template <class M>
concept HasAdvance = requires(const M& model, typename M::Scalar (&z)[M::kNz], const typename M::Scalar (&y)[M::kNr],
                              typename M::Scalar dt_s) {
  model.advance(z, y, y, dt_s);
};
template <class M>
concept HasDrivenAdvance = requires(const M& model, typename M::Scalar (&z)[M::kNz],
                                    const typename M::Scalar (&y)[M::kNr], const typename M::Scalar (&u)[M::kNu],
                                    typename M::Scalar dt_s) {
  model.advance(z, y, y, u, u, dt_s);
};
template <class M>
concept HasAdvanceByArrivals = requires(const M& model, typename M::Scalar (&z)[M::kNz],
                                        const typename M::Scalar (&y)[M::kNr], const Vector<bool, M::kNy>& arrived,
                                        typename M::Scalar dt_s) {
  M::kReadsArrivals;
  model.advance(z, y, y, arrived, dt_s);
};
template <class M>
concept HasStep = HasAdvance<M> || HasDrivenAdvance<M> || HasAdvanceByArrivals<M>;
template <class M>
concept HasEstimate = requires(const M& model, const typename M::Scalar (&z)[M::kNz],
                               const typename M::Scalar (&y)[M::kNr], typename M::Scalar (&x_hat)[M::kNx]) {
  model.estimate(z, y, x_hat);
};

/// A model that an observer can step. The compiler names the requirement that a model does not meet.
template <class M>
concept ObserverModel = HasSizes<M> && HasValues<M> && HasStep<M> && HasEstimate<M>;

/// T* of the model has an ErrorHead (error_head.h).
template <class M>
concept KnowsError = M::InverseMap::kHasError;

/// Steps a model. With the deterministic policy a step of one sample period executes the same number of instructions
/// for every input, once the observer has started.
template <ObserverModel Model_, Arithmetic kArithmetic_>
class ObserverCore {
 public:
  using Model = Model_;
  using Scalar = typename Model::Scalar;
  static constexpr Arithmetic kArithmetic = kArithmetic_;
  static constexpr int kNx = Model::kNx;
  static constexpr int kNy = Model::kNy;
  static constexpr int kNz = Model::kNz;
  static constexpr int kNu = Model::kNu;
  static constexpr int kNr = Model::kNr;
  static constexpr bool kDriven = kNu > 0;  ///< step() takes u
  static constexpr int kNf = Model::kNf;
  static constexpr bool kSlow = kHasSlowOutputs<Model>;   ///< outputs have periods of their own
  static constexpr bool kReadsInputs = kNr - kNf > kNy;   ///< inputs are readings
  static constexpr int kActing = kReadsInputs ? 0 : kNu;  ///< inputs that are not readings
  using Latent = Vector<Scalar, kNz>;
  using Estimate = Vector<Scalar, kNx>;
  using State = ObserverState<Scalar, kNr, kNz, kActing>;

  /// The model must outlive the observer; generated models are constants.
  constexpr explicit ObserverCore(const Model& model) : model_(&model) { reset(); }
  explicit ObserverCore(const Model&&) = delete;

  /// Forgets everything: z = z(0), and the next measurement is the first.
  constexpr void reset() {
    restart(state_, model_->initial_latent());
    for (int j = 0; kSlow && j < kNr; ++j)
      if (not_due<Model>(j) > 0) state_.health[j] = never_arrived(not_due<Model>(j));
  }

  /// Returns x_hat = T*(z, y), n_x. It is computed on each call, at the cost of the inverse map.
  [[nodiscard]] Estimate estimate() const {
    Estimate x_hat;
    if constexpr (kArithmetic == Arithmetic::kFast) {
      model_->estimate(state_.z, state_.y, x_hat.values);
    } else {
      model_->template estimate<kArithmetic>(state_.z, state_.y, x_hat.values);
    }
    return x_hat;
  }

  /// Returns x_hat and the half widths of its intervals (error_head.h), for models with an error head. The half widths
  /// are kUnknownSigma outside of the domain and from status kStale on.
  [[nodiscard]] auto estimate_with_error() const requires KnowsError<Model> {
    return model_->inverse_map.error.template estimate<kArithmetic>(*model_, state_.z, state_.y, error_is_known());
  }

  /// Returns z, n_z.
  [[nodiscard]] constexpr Latent latent() const {
    Latent z{};
    for (int r = 0; r < kNz; ++r) z[r] = state_.z[r];
    return z;
  }

  /// Returns the status of the latest step, or kReset if a bit flip has corrupted z or a stored reading since then.
  /// After kReset estimate() is meaningless until the next step.
  [[nodiscard]] constexpr StepStatus status() const {
    return is_reachable<Model>(state_, model_->outputs) ? state_.status : StepStatus::kReset;
  }

  /// Status of one channel in the latest step: output j, or input kNy + i. The step's status is the worst of all.
  /// kRejected and kReset apply to every channel. kRejected is also returned for a channel number out of range.
  [[nodiscard]] constexpr StepStatus status(int channel) const {
    const StepStatus all = status();
    if (all == StepStatus::kRejected || all == StepStatus::kReset) return all;
    if (channel < 0 || channel >= kNy + kNu) return StepStatus::kRejected;
    const int at = channel < kNr - kNf ? channel : channel + kNf;
    return status_of<kArithmetic>(counted_health(at), model_->stale_after);
  }

  /// Returns true if output j arrived in the latest step; always true for an output without its own period. Between
  /// its samples a slow output has not arrived, although its status is kOk.
  [[nodiscard]] constexpr bool has_arrived(int output) const {
    return !is_slow(output) || (state_.health[output] & kHeldBit) == 0;
  }

  /// Returns true if z is within the range of the training and no reading is clamped. Otherwise estimate()
  /// extrapolates.
  [[nodiscard]] constexpr bool in_domain() const {
    ChannelHealth any = 0;
    for (const ChannelHealth health : state_.health) any |= health;
    return static_cast<int>((any & kClampedBit) == 0) &
           static_cast<int>(model_->domain.contains(relative_latent().values));
  }

  /// Returns true if the intervals of estimate_with_error() hold: z is in the domain, no reading is stale or clamped.
  [[nodiscard]] constexpr bool error_is_known() const {
    return (static_cast<int>(in_domain()) & static_cast<int>(state_.status < StepStatus::kStale)) != 0;
  }

  /// Returns z - S y over the outputs that T* reads only through that difference, such as angles. Without such outputs
  /// this is z.
  [[nodiscard]] constexpr Latent relative_latent() const {
    Latent rest{};
    add_relative_state(*model_, state_.y, rest.values);
    Latent z = latent();
    for (int r = 0; r < kNz; ++r) z[r] -= rest[r];
    return z;
  }

  /// Returns the staleness of an output that may be missing: 0 while it is measured; it approaches 1 while it is
  /// missing.
  [[nodiscard]] constexpr Scalar staleness(int output) const requires(kNf > 0) {
    Scalar stale = 0;
    for (int i = 0; i < kNf; ++i) stale = model_->failures.output[i] == output ? state_.y[kNr - kNf + i] : stale;
    return stale;
  }

  [[nodiscard]] constexpr const Model& model() const { return *model_; }
  [[nodiscard]] constexpr State save() const { return state_; }

  /// Continues from a saved state. Returns false and changes nothing if steps cannot lead to that state.
  [[nodiscard]] constexpr bool restore(const State& saved) {
    if (!is_reachable<Model>(saved, model_->outputs)) return false;
    state_ = saved;
    return true;
  }

 protected:
  using Readings = Vector<Scalar, kNr>;
  using Acting = Vector<Scalar, kActing == 0 ? 1 : kActing>;

  constexpr bool possible(Scalar dt_s) const {
    return is_finite(dt_s) && dt_s > Scalar(0) && dt_s <= Scalar(Model::kLongestGap) * model_->sample_period_s;
  }

  /// One step. kRegular: over one sample period; dt_s is ignored, and code for other steps is not compiled in.
  template <bool kRegular>
  NLO_OWN_FRAME constexpr StepStatus step_by(Readings y, const Acting& u, Scalar dt_s) {
    Arrivals arrived = finite_outputs(y);
    const Missing missing = fill_missing<kRegular>(y, state_.started == 1, dt_s);
    Scalar y_next[kNr]{};
    for (int j = 0; j < kNr; ++j) y_next[j] = state_.y[j];  // validate() overwrites usable ones
    InputMemory<Scalar, kActing> u_next = state_.input;
    const bool held = validate<kRegular>(y, u, y_next, u_next, dt_s);
    update_status(missing);
    leave_out_held(arrived);
    bool reachable = false;  // true if the model has shown that z is reachable
    if (state_.started == 1) {
      reachable = advance(y_next, arrived, u_next, kRegular ? Scalar(0) : dt_s);  // z <- A z + B0 y + B1 y_next
      for (int j = 0; j < kNr; ++j) state_.y[j] = y_next[j];                      // y <- y_next
      turn_back<kArithmetic>(*model_, state_.y, state_.z);  // removes whole turns a: y - a, z - S a
    } else {
      if (!is_reachable<Model>(state_, model_->outputs)) return reset_after_corruption();
      if (held && !(kSlow && all_known())) {  // no value to start from yet
        keep_slow(y_next);
        return state_.status;
      }
      start(y_next, arrived, starts_steady(*model_));  // z <- z(0), or z(0) + S y
    }
    state_.input = u_next;
    return is_sound(held, reachable) ? state_.status : reset_after_corruption();
  }

  /// Starts from the steady state of y, z = z(0) + S y.
  constexpr StepStatus start_steady(Readings y) {
    Arrivals arrived = finite_outputs(y);
    const Missing missing = fill_missing<true>(y, false, Scalar(0));
    Scalar accepted[kNr]{};
    for (int j = 0; kSlow && j < kNr; ++j)
      if (not_due<Model>(j) > 0) accepted[j] = state_.y[j];
    const bool held = model_->outputs.template validate<kArithmetic, Model>(y, accepted, state_.health);
    for (int i = 0; i < kActing; ++i) state_.health[kNr + i] = 0;
    update_status(missing);
    if (held && !(kSlow && all_known()))
      return is_reachable<Model>(state_, model_->outputs) ? state_.status : reset_after_corruption();
    const auto& initial = model_->initial_latent();
    for (int r = 0; r < kNz; ++r) state_.z[r] = initial[r];
    state_.input = {};
    leave_out_held(arrived);
    start(accepted, arrived, true);
    return state_.status;
  }

  const Model* model_;
  State state_{};

 private:
  static constexpr int kFailing = kNf == 0 ? 1 : kNf;
  /// State of the outputs that may fail, in one sample.
  struct Missing {
    Vector<bool, kFailing> missing{};
    Vector<ChannelHealth, kSlow ? kFailing : 1> absent{};  ///< health of a slow output; 0: it arrived
  };

  static constexpr bool kReadsArrivals = requires { Model::kReadsArrivals; };
  using Arrivals = Vector<bool, kReadsArrivals ? Model::kNy : 1>;

  /// Returns which outputs of a sample are finite, before missing ones are replaced.
  static constexpr Arrivals finite_outputs([[maybe_unused]] const Readings& y) {
    Arrivals finite{};
    if constexpr (kReadsArrivals)
      for (int j = 0; j < Model::kNy; ++j) finite[j] = is_finite(y[j]);
    return finite;
  }

  /// After validation: clears `arrived` for outputs whose last good value was used instead.
  constexpr void leave_out_held([[maybe_unused]] Arrivals& arrived) const {
    if constexpr (kReadsArrivals)
      for (int j = 0; j < Model::kNy; ++j) arrived[j] = arrived[j] & ((state_.health[j] & 3U) != kHeldBit);
  }

  /// Replaces missing outputs (sensor_failures.h). Returns which ones were missing.
  template <bool kRegular>
  constexpr Missing fill_missing(Readings& y, bool started, Scalar dt_s) const {
    if constexpr (kNf == 0) {
      return {};
    } else {
      const Scalar k = kRegular ? model_->failures.keep : model_->failures.keep_over(dt_s);
      Missing sample;
      if constexpr (kSlow) {  // a slow output that is not late holds its last value
        const int missed = kRegular || !started ? 0 : missed_samples(dt_s, model_->sample_period_s);
        for (int i = 0; i < kNf; ++i) {
          const int j = model_->failures.output[i];
          if (!is_slow(j)) continue;
          const ChannelHealth absent = absent_health(state_.health[j], missed, not_due<Model>(j));
          const bool given = is_finite(y[j]), late = (absent >> 2U) > most_missing(not_due<Model>(j));
          sample.absent[i] = select<kArithmetic>(given, ChannelHealth{0}, absent);
          y[j] = select<kArithmetic>(given | late, y[j], state_.y[j]);
        }
      }
      sample.missing =
          model_->failures.template fill<kArithmetic>(y, state_.y, select<kArithmetic>(started, k, Scalar(0)));
      return sample;
    }
  }

  /// Validates a sample: overwrites y_next and u_next, which hold the last good values, with its usable values, and
  /// updates the health of each channel. Returns true if one of them was held.
  template <bool kRegular>
  NLO_INLINE constexpr bool validate(const Readings& y, const Acting& u, Scalar (&y_next)[kNr],
                                     InputMemory<Scalar, kActing>& u_next, [[maybe_unused]] Scalar dt_s) {
    if constexpr (kRegular) {
      return validate(y, u, y_next, u_next);
    } else {
      const int missed = state_.started == 1 ? missed_samples(dt_s, model_->sample_period_s) : 0;
      ChannelHealth before[kNr + kActing]{};
      for (int i = 0; i < kNr + kActing; ++i)
        state_.health[i] = before[i] = health_after_missed(state_.health[i], missed, is_slow(i) ? kClampedBit : 0U);
      const bool held = validate(y, u, y_next, u_next);
      for (int i = 0; missed > 0 && i < kNr + kActing; ++i)
        state_.health[i] = health_after_gap(before[i], state_.health[i]);
      return held;
    }
  }
  NLO_INLINE constexpr bool validate(const Readings& y, const Acting& u, Scalar (&y_next)[kNr],
                                     InputMemory<Scalar, kActing>& u_next) {
    bool held = model_->outputs.template validate<kArithmetic, Model>(y, y_next, state_.health);
    if constexpr (kActing > 0) held |= u_next.template validate<kArithmetic>(u, state_.health + kNr);
    return held;
  }

  /// Sets the status of a sample: the worst of its channels. An output declared as may_fail reports kHeld while it is
  /// missing, and never counts towards kStale.
  NLO_INLINE constexpr void update_status(const Missing& sample) {
    if constexpr (kNf > 0) {
      for (int i = 0; i < kNf; ++i) {
        const int j = model_->failures.output[i];
        ChannelHealth& health = state_.health[j];
        if (is_slow(j)) {
          const auto clamped = static_cast<ChannelHealth>(1U << 2U | (health & 3U));
          const ChannelHealth arrived = select<kArithmetic>((health & kClampedBit) == 0, health, clamped);
          health = select<kArithmetic>(sample.absent[i] == 0, arrived, sample.absent[i]);
        } else {
          health = select<kArithmetic>(!sample.missing[i], health, kHeldOnce);
        }
      }
    }
    if constexpr (!kConstantTime<kArithmetic>) {
      ChannelHealth any = 0;
      for (const ChannelHealth health : state_.health) any |= health;
      if (any == 0) [[likely]] {
        state_.status = StepStatus::kOk;
        return;
      }
    }
    StepStatus worst = status_of<kArithmetic>(counted_health(0), model_->stale_after);
    for (int i = 1; i < kNr + kActing; ++i)
      worst = worse<kArithmetic>(worst, status_of<kArithmetic>(counted_health(i), model_->stale_after));
    state_.status = worst;
  }

  static constexpr bool is_slow(int i) { return kSlow && i < kNr && not_due<Model>(i) > 0; }

  /// Returns the health from which the status of channel i follows.
  constexpr ChannelHealth counted_health(int i) const {
    if constexpr (kSlow && kNf > 0) {
      for (int f = 0; f < kNf; ++f)
        if (is_slow(i) && model_->failures.output[f] == i)
          return due_health_of_failing(state_.health[i], not_due<Model>(i));
    }
    return is_slow(i) ? due_health(state_.health[i], not_due<Model>(i)) : state_.health[i];
  }

  /// Returns true if each channel has arrived in this sample, or is a slow output that is not late.
  constexpr bool all_known() const {
    ChannelHealth any = 0;
    for (int i = 0; i < kNr + kActing; ++i) any |= counted_health(i);
    return (any & kHeldBit) == 0;
  }

  /// Stores slow outputs that arrive before the observer has started.
  constexpr void keep_slow(const Scalar (&y)[kNr]) {
    for (int j = 0; kSlow && j < kNr; ++j)
      if (is_slow(j)) state_.y[j] = start_value(j, y[j]);
  }

  constexpr Scalar start_value(int j, Scalar y) const {
    const Scalar turn = model_->outputs.wrap[j];
    return turn > Scalar(0) ? ReadingRange<Scalar, kNr>::template wrapped<kArithmetic>(y, turn) : y;
  }

  /// Returns true if steps can lead to this state. A bit flip in a stored reading reaches z only after several steps,
  /// so stored readings that are reused are checked here.
  NLO_INLINE constexpr bool is_sound(bool held, bool reachable) const {
    bool sound = reachable || is_reachable(state_.z);
    sound = sound & state_.input.is_reachable();
    if (kArithmetic == Arithmetic::kDeterministic || held) sound = sound & (!held | model_->outputs.may_hold(state_.y));
    return sound;
  }

  /// Resets after a bit flip has corrupted the state. The next measurement then starts the observer.
  constexpr StepStatus reset_after_corruption() {
    reset();
    return state_.status = StepStatus::kReset;
  }

  constexpr void start(const Scalar (&y)[kNr], [[maybe_unused]] const Arrivals& arrived, bool steady) {
    for (int j = 0; j < kNr; ++j) state_.y[j] = start_value(j, y[j]);
    if (steady) add_steady_state(*model_, state_.y, state_.z);
    if constexpr (kReadsArrivals)
      model_->template start<kArithmetic>(state_.y, arrived, state_.z);
    else if constexpr (requires { model_->template start<kArithmetic>(state_.y, state_.z); })
      model_->template start<kArithmetic>(state_.y, state_.z);
    state_.started = 1;
  }

  /// Advances z. Returns true if the model has shown that the new z is reachable.
  NLO_INLINE constexpr bool advance(const Scalar (&y_next)[kNr], [[maybe_unused]] const Arrivals& arrived,
                                    const InputMemory<Scalar, kActing>& u_next, Scalar dt_s) {
    constexpr bool kInPlace = !Model::kMayDiverge && kNz > 16;  // a copy of a large z would take much stack
    Scalar copy[kNz]{};
    Scalar(&z)[kNz] = kInPlace ? state_.z : copy;
    for (int r = 0; !kInPlace && r < kNz; ++r) z[r] = state_.z[r];
    if constexpr (kReadsInputs) {
      // With zero-order hold, the input of this step has acted since the last sample. Both ends of the interval get
      // this input, so that its ramp, by the first-order hold of the outputs, is constant.
      for (int j = kNy; Model::kInputHold == Hold::kZeroOrder && j < kNy + kNu; ++j) state_.y[j] = y_next[j];
    }
    bool reachable = false;
    if constexpr (kReadsArrivals) {
      model_->template advance<kArithmetic>(z, state_.y, y_next, arrived, dt_s);
    } else if constexpr (kActing > 0) {
      model_->template advance<kArithmetic>(z, state_.y, y_next, state_.input.u, u_next.u, dt_s);
    } else if constexpr (kArithmetic == Arithmetic::kFast) {
      if constexpr (std::is_same_v<decltype(model_->advance(z, state_.y, y_next, dt_s)), bool>) {
        reachable = model_->advance(z, state_.y, y_next, dt_s);
      } else {
        model_->advance(z, state_.y, y_next, dt_s);
      }
    } else {
      model_->template advance<kArithmetic>(z, state_.y, y_next, dt_s);
    }
    if constexpr (Model::kMayDiverge) {
      if (!is_reachable(z) && is_reachable(state_.z)) {  // keeps the old z, which may recover later
        state_.status = StepStatus::kDiverged;
        return false;
      }
    }
    // Tiny values become 0. Otherwise z would stay subnormal while y is 0, and subnormals are slow on some cores.
    constexpr Scalar kTiny = Scalar(0x1p-100);
    if (kInPlace && reachable) [[likely]]
      return true;
    for (int r = 0; r < kNz; ++r) state_.z[r] = select<kArithmetic>(!is_below(z[r], kTiny), z[r], Scalar(0));
    return reachable;
  }
};

}  // namespace nlo::inline NLO_ISA
