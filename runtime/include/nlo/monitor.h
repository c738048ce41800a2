// SPDX-License-Identifier: MIT
// Detects in flight that an estimate is wrong because the plant is not that of the training, a sensor is worse or dead,
// or training never reached the state. The monitor watches the innovation (the change of an output minus the change
// that was predicted one sample earlier), the distance of z from training, and the difference between T* and a linear
// fit of it:
//
//   off_r = (z - S y - mean)_r / deviation_r
//   e_j = (dy_j - P_j [z - S y; y; x_hat] - c_j) / (deviation_j (1 + motion_j mean_r |off_r|))
//                     dy_j: change of output j since the last sample; z, y, x_hat and off are those of the last sample
//   m <- m + a (e - m),  v <- v + a (e^2 - v),  r <- r + a (e e_last - r)      a = 1 - exp(-period / window)
//   p <- p + a_longest (m^2 - p)           mean square of the smoothed innovation: large after a long bias
//   d <- d + a (mean_r off_r^2 - d)
//   q_j <- q_j + a (missing_j - q_j)       share of missing samples, over the first window
//   b_i <- b_i + a (|x_hat_i - row_i [z - S y; y] - c_i| / deviation_i - b_i)
//                     disagreement of state i, over the second window if there is one, else over the first
//
// A slow output (measurement.h) has an innovation when it arrives. Between its samples it keeps its last innovation and
// is not missing. It is missing once it is late by half its period. Its r is not watched and stays 0.
//
// The alarm is raised while one of p / max(v, least_variance), v, |r|, d, q, b is above its limit. Limits come from
// runs or logs like those of the training, for a stated number of false alarms per hour (nlo monitor). Each e counts as
// kLargestInnovation at most, so that one outlier raises no alarm.
//
// usable_outputs() also keeps outliers from the observer: once the monitor is armed, it rejects an output whose |e| is
// beyond the gate, which widens with sqrt(v). After kMostRejected rejections in a row it believes the sensor until the
// innovation is ordinary again. It also rejects a frozen sensor, one that repeats a reading for longer than in training
// or while the prediction moves on. If the model sets `replaces` for an output, the prediction replaces a measurement
// that is missing or beyond the gate, because an observer that holds the last measurement has a large error while the
// plant moves.
//
// widened() widens the intervals of an estimate by the disagreement.
//
// No heap, no exceptions, no libm. Every statistic stays finite for any input. Statistics that no samples can produce
// come from corrupted memory: the alarm is kReset, and the monitor starts again. It counts samples, not seconds, so
// steps may jitter as much as in training. After a gap that made the observer stale it arms again by itself.
#pragma once

#include <cstdint>
#include <limits>

#include "nlo/estimate_with_error.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"
#include "nlo/measurement.h"
#include "nlo/monitor_model.h"
#include "nlo/vector.h"

namespace nlo::inline NLO_ISA {

/// Monitors one observer. kArithmetic: as for KklObserver.
template <class Model_, Arithmetic kArithmetic = Arithmetic::kFast>
class Monitor {
 public:
  using Model = Model_;
  using Scalar = typename Model::Scalar;
  static constexpr int kNx = Model::kNx, kNy = Model::kNy, kNz = Model::kNz, kNr = Model::kNr;
  using Output = Vector<Scalar, kNy>;
  /// Number of outputs that the observer takes; it may compute further ones from them.
  template <class Observer>
  static constexpr int kMeasured = [] {
    if constexpr (requires { Observer::kMeasured; }) return Observer::kMeasured;
    return kNy;
  }();
  template <class Observer>
  using Measured = Vector<Scalar, kMeasured<Observer>>;
  using Estimate = Vector<Scalar, kNx>;

  struct Window {
    Scalar mean, power, variance, correlation;
  };
  struct OutputState {
    Window windows[Model::kWindows];
    Scalar y, predicted, last;  // the last reading, the change predicted from there [deviations], the last innovation
    Scalar missing_share;
    Scalar raw;             // the last finite measurement, used or not
    Scalar moved;           // predicted change since `raw` began to repeat [deviations]
    std::uint16_t equal;    // repetitions of `raw` in a row, none at rest; kFrozen: until `raw` changes
    std::uint8_t rejected;  // rejections in a row
    std::uint8_t missing;   // in the sample that watch() judges next; not a bool, because a bit flip may make any byte
  };
  /// The state of a monitor: everything that a sample changes.
  struct State {
    OutputState outputs[kNy];
    Scalar distance[Model::kWindows];
    Scalar disagreement[kNx];
    Scalar place;  // mean |off| of the last sample
    Scalar level;
    int samples;  // number since the start; stops when armed
    Alarm alarm;
    std::uint8_t gated;  // 1: usable_outputs() was called for the sample that watch() judges next
  };

  /// The model must outlive the monitor; generated models are constants.
  constexpr explicit Monitor(const Model& model) : model_(&model) { reset(); }
  explicit Monitor(const Model&&) = delete;

  /// Forgets everything. After a reset() of the observer, the next usable_outputs() or watch() does this by itself.
  constexpr void reset() {
    state_ = State{};
    for (auto& output : state_.outputs)
      for (Window& window : output.windows) window.variance = 1;
    for (Scalar& distance : state_.distance) distance = 1;
  }

  /// Returns the measurements that the observer may use. Measurements that the gate rejects, or that a frozen sensor
  /// repeats, are replaced by NaN; the observer then holds the last good value. For an output with `replaces`, the
  /// predicted measurement replaces up to kMostRejected in a row that are missing or rejected. The status of the
  /// observer is then kOk; the alarm kMissing reports too many of them. Call it before step(); watch() judges the same
  /// sample afterwards.
  ///   dt_s  time step that step() gets [s], 0: one sample period. A reading after a gap is not compared with the
  ///         prediction, which is for one sample period
  template <class Observer>
  [[nodiscard]] constexpr Measured<Observer> usable_outputs(Measured<Observer> y, const Observer& observer,
                                                            Scalar dt_s = 0) {
    const bool gap = dt_s > Scalar(1.5) * observer.model().sample_period_s;
    const bool first = observer.save().started != 1;  // this is the observer's first measurement
    if (first) reset();
    state_.gated = 1;
    for (int j = 0; j < kMeasured<Observer>; ++j) {
      OutputState& own = state_.outputs[j];
      const bool given = is_finite(y[j]);
      own.missing = !given && !is_slow<Observer>(j);  // watch() judges whether a slow output is late
      if (!given) {
        if (may_replace(j, gap)) y[j] = replacement(j);
        continue;
      }
      count_repeats(own, j, y[j], y[model_->reference_sensor[j]]);
      if (first) continue;
      bool rejects = false;
      if (armed() && !gap) {
        const Scalar e = innovation(j, y[j], observer.model().outputs.wrap[j]);
        const Scalar noise = own.windows[0].variance > Scalar(1) ? own.windows[0].variance : Scalar(1);
        const bool beyond = e * e > model_->gate_squared * noise;
        rejects = beyond && own.rejected < most_rejected();
        if (!beyond) own.rejected = 0;
        if (rejects) ++own.rejected;
      }
      own.missing = rejects || own.equal == kFrozen;
      if (own.missing == 1)
        y[j] = rejects && model_->replaces[j] != 0 ? predicted(j) : std::numeric_limits<Scalar>::quiet_NaN();
    }
    for (int j = kMeasured<Observer>; j < kNy; ++j) {  // computed from outputs that may be missing
      state_.outputs[j].missing = 0;
      for (const Scalar measured : y)
        if (!is_slow<Observer>(j)) state_.outputs[j].missing |= static_cast<std::uint8_t>(!is_finite(measured));
    }
    return y;
  }
  template <class Observer>
  [[nodiscard]] constexpr Scalar usable_outputs(Scalar y, const Observer& observer,
                                                Scalar dt_s = 0) requires(kMeasured<Observer> == 1) {
    return usable_outputs(Measured<Observer>{{y}}, observer, dt_s)[0];
  }
  template <class Y, class Observer>
  [[deprecated("it is called usable_outputs()")]] [[nodiscard]] constexpr auto trusted(const Y& y,
                                                                                       const Observer& observer,
                                                                                       Scalar dt_s = 0) {
    return usable_outputs(y, observer, dt_s);
  }
  template <class Y, class Observer>
  [[deprecated("it is called usable_outputs()")]] [[nodiscard]] constexpr auto screened(const Y& y,
                                                                                        const Observer& observer) {
    return usable_outputs(y, observer);
  }

  /// Judges the latest step of `observer`; call it after each step, with the estimate of that step. Without
  /// usable_outputs() before the step, nothing is rejected, and the alarms are the same. Returns kReset if that step
  /// has reset the observer, or if the monitor's memory is corrupted.
  template <class Observer>
  [[nodiscard]] constexpr Alarm watch(const Observer& observer, const Estimate& x_hat) {
    static_assert(Observer::kNz == kNz && Observer::kNr == kNr && Observer::kNx == kNx, "the monitor of another model");
    const auto taken = observer.save();
    if (taken.started != 1)  // the observer has no measurement yet
      return begin_again(taken.status == StepStatus::kReset ? Alarm::kReset : Alarm::kNone);
    const auto& y = taken.y;  // readings: held, clamped, angles within a turn
    const auto z = observer.relative_latent();
    bool stale = false;
    for (int j = 0; j < kNy; ++j) {
      OutputState& own = state_.outputs[j];
      const StepStatus status = observer.status(j);
      const bool arrived = !is_slow<Observer>(j) || has_arrived(observer, j);
      if (state_.gated != 1) {
        own.missing = 0;
        if (status < StepStatus::kHeld && arrived) count_repeats(own, j, y[j], y[model_->reference_sensor[j]]);
      }
      if (status >= StepStatus::kHeld || own.equal == kFrozen) own.missing = 1;
      stale = stale || status >= StepStatus::kStale;
      if (state_.samples > 0 && own.missing == 0)
        update_averages(own, arrived ? innovation(j, y[j], observer.model().outputs.wrap[j]) : own.last,
                        is_slow<Observer>(j));
    }
    state_.gated = 0;
    update_place(z);
    update_disagreement(z, y, x_hat);
    predict(z, y, x_hat);
    if (state_.samples <= model_->armed_after) ++state_.samples;
    if (stale) state_.samples = 0;  // once readings are back, x_hat has a transient again
    return judge() ? state_.alarm : begin_again(Alarm::kReset);
  }

  /// Returns an estimate with error (observer.estimate_with_error()) with wider intervals. Call it after watch().
  ///   no alarm  sigma_i and bound_95_i are multiplied by max(1, b_i / kOrdinaryDisagreement)
  ///   alarm     the error is unknown: sigma_i = kUnknownSigma, and bound_95_i is a multiple of it
  /// Limits and gate do not depend on the intervals.
  [[nodiscard]] constexpr EstimateWithError<Scalar, kNx> widened(EstimateWithError<Scalar, kNx> estimate) const {
    for (int i = 0; i < kNx; ++i) {
      const Scalar times = state_.disagreement[i] * (Scalar(1) / Scalar(kOrdinaryDisagreement));
      const Scalar wider = times > Scalar(1) ? times : Scalar(1);
      const Scalar ratio = estimate.bound_95[i] / estimate.sigma[i];
      const bool known = state_.alarm == Alarm::kNone && estimate.sigma[i] < Scalar(kUnknownSigma);
      estimate.sigma[i] = known ? estimate.sigma[i] * wider : Scalar(kUnknownSigma);
      estimate.bound_95[i] = known ? estimate.bound_95[i] * wider : ratio * Scalar(kUnknownSigma);
    }
    return estimate;
  }

  /// True once the monitor has seen enough samples: before, watch() returns no alarm but kMissing and kReset, and
  /// usable_outputs() rejects nothing. False again after a reset of the observer, and while it is stale.
  [[nodiscard]] constexpr bool armed() const { return state_.samples > model_->armed_after; }

  [[nodiscard]] constexpr State save() const { return state_; }

  /// Continues from a saved state. Call it together with the observer's restore(). Returns false and changes nothing if
  /// watch() cannot lead to that state.
  [[nodiscard]] constexpr bool restore(const State& saved) {
    if (!is_reachable(saved)) return false;
    state_ = saved;
    return true;
  }

  /// Returns the alarm of the latest watch().
  [[nodiscard]] constexpr Alarm alarm() const { return state_.alarm; }

  /// Returns the largest ratio of a statistic to its limit. Above 1 the armed monitor raises an alarm. 0 after kReset.
  [[nodiscard]] constexpr Scalar level() const { return state_.level; }

 private:
  /// Returns true if output j has a period of its own.
  template <class Observer>
  static constexpr bool is_slow([[maybe_unused]] int j) {
    if constexpr (requires { Observer::kSlow; }) return Observer::kSlow && not_due<typename Observer::Model>(j) > 0;
    return false;
  }
  template <class Observer>
  static constexpr bool has_arrived([[maybe_unused]] const Observer& observer, [[maybe_unused]] int j) {
    if constexpr (requires { observer.has_arrived(j); }) return observer.has_arrived(j);
    return true;
  }

  static constexpr Scalar kFar = Scalar(1e6);  // deviations; its square is finite
  static constexpr std::uint16_t kFrozen = 65535;
  // An average stays within the range of its values, apart from rounding.
  static constexpr Scalar kMostSquare = Scalar(kLargestInnovation * kLargestInnovation) * Scalar(1.01);

  constexpr Alarm begin_again(Alarm why) {
    reset();
    return state_.alarm = why;
  }

  constexpr bool is_reachable(const State& state) const {
    const auto within = [](Scalar value, Scalar most) { return value >= -most && value <= most; };
    bool good = state.samples >= 0 && state.samples <= model_->armed_after + 1 && state.alarm <= Alarm::kReset &&
                is_finite(state.level);
    for (const Scalar distance : state.distance) good = good && within(distance, kMostSquare);
    for (const Scalar disagreement : state.disagreement) good = good && within(disagreement, kMostSquare);
    good = good && within(state.place, Scalar(kLargestInnovation)) && state.gated <= 1;
    for (const OutputState& own : state.outputs) {
      good = good && is_finite(own.y) && within(own.predicted, kFar) && within(own.last, Scalar(kLargestInnovation)) &&
             within(own.missing_share, Scalar(1.01)) && is_finite(own.raw) && within(own.moved, kFar) &&
             own.rejected <= kMostRejected && own.missing <= 1;
      for (const Window& window : own.windows)
        good = good && within(window.mean, kMostSquare) && within(window.power, kMostSquare) &&
               within(window.variance, kMostSquare) && within(window.correlation, kMostSquare);
    }
    return good;
  }

  /// Returns the limit of rejections in a row, at most the samples that the monitor takes to arm. A jump of the true
  /// state looks like outliers until the gate accepts the sensor again.
  constexpr int most_rejected() const {
    return model_->armed_after < kMostRejected ? model_->armed_after : kMostRejected;
  }

  /// Counts successive measurements that are equal to the bit, unless the sensor is at rest, and adds up the changes
  /// that were predicted meanwhile. If either reaches its limit, the sensor is frozen until its reading changes.
  constexpr void count_repeats(OutputState& own, int j, Scalar y, Scalar reference_sensor) const {
    const bool moves =
        reference_sensor < model_->rest_min[j] || reference_sensor > model_->rest_max[j];  // false if it is missing
    const bool at_rest = y == model_->resting[j] && !moves && own.equal != kFrozen;
    const bool repeats = y == own.raw;
    own.moved = repeats && armed() ? limited(own.moved + own.predicted, kFar) : Scalar(0);
    if (!repeats || at_rest) {
      own.equal = 0;
    } else if (own.equal < kFrozen - 1) {
      ++own.equal;
    }
    const Scalar moved = own.moved < Scalar(0) ? -own.moved : own.moved;
    const bool too_often = model_->most_equal[j] > 0 && own.equal >= model_->most_equal[j];
    if (too_often || (model_->most_moved[j] > Scalar(0) && moved > model_->most_moved[j])) own.equal = kFrozen;
    own.raw = y;
  }

  static constexpr Scalar limited(Scalar value, Scalar largest) {  // NaN gives -largest
    const Scalar below = value < largest ? value : largest;
    return below > -largest ? below : -largest;
  }

  static constexpr Scalar multiply_add(Scalar a, Scalar b, Scalar c) { return nlo::multiply_add<kArithmetic>(a, b, c); }

  constexpr Scalar innovation(int j, Scalar y, Scalar turn) const {
    const OutputState& own = state_.outputs[j];
    Scalar change = y - own.y;
    if (turn > Scalar(0)) change = ReadingRange<Scalar, 1>::template wrapped<kArithmetic>(change, turn);
    const Scalar size = multiply_add(model_->motion[j], state_.place, Scalar(1));
    return limited(multiply_add(change, model_->per_deviation[j], -own.predicted) / size, kFar);
  }

  /// Returns true if a prediction may replace a missing measurement. After a gap it may not: it is for one period.
  constexpr bool may_replace(int j, bool gap) const {
    return model_->replaces[j] != 0 && armed() && !gap && state_.outputs[j].rejected < most_rejected();
  }
  constexpr Scalar replacement(int j) {
    ++state_.outputs[j].rejected;
    return predicted(j);
  }
  /// Returns the measurement that was predicted for this sample. If it is not finite, the observer holds the last one.
  constexpr Scalar predicted(int j) const {
    const OutputState& own = state_.outputs[j];
    return own.y + own.predicted / model_->per_deviation[j];
  }

  constexpr void update_averages(OutputState& own, Scalar innovation, bool slow) {
    const Scalar e = limited(innovation, Scalar(kLargestInnovation));
    for (int w = 0; w < Model::kWindows; ++w) {
      Window& window = own.windows[w];
      const Scalar gain = model_->gain[w];
      window.mean = multiply_add(gain, e - window.mean, window.mean);
      window.power = multiply_add(model_->gain[Model::kWindows - 1],
                                  multiply_add(window.mean, window.mean, -window.power), window.power);
      window.variance = multiply_add(gain, multiply_add(e, e, -window.variance), window.variance);
      if (!slow)
        window.correlation = multiply_add(gain, multiply_add(e, own.last, -window.correlation), window.correlation);
    }
    own.last = e;
  }

  /// Updates the distance of z from training and the share of missing measurements.
  template <class Latent>
  constexpr void update_place(const Latent& z) {
    Scalar squares = 0, sizes = 0;
    for (int r = 0; r < kNz; ++r) {
      const Scalar off = limited((z[r] - model_->latent_mean[r]) * model_->per_latent_deviation[r], kFar);
      squares = multiply_add(off, off, squares);
      sizes += off < Scalar(0) ? -off : off;
    }
    state_.place = limited(sizes * (Scalar(1) / Scalar(kNz)), Scalar(kLargestInnovation));
    const Scalar mean = limited(squares * (Scalar(1) / Scalar(kNz)), Scalar(kLargestInnovation * kLargestInnovation));
    for (int w = 0; w < Model::kWindows; ++w) {
      Scalar& distance = state_.distance[w];
      distance = multiply_add(model_->gain[w], mean - distance, distance);
    }
    for (OutputState& own : state_.outputs) {
      const Scalar missing = own.missing != 0 ? Scalar(1) : Scalar(0);
      own.missing_share = multiply_add(model_->gain[0], missing - own.missing_share, own.missing_share);
      own.missing = 0;
    }
  }

  /// Compares x_hat with the linear fit of T*.
  template <class Latent, class Readings>
  constexpr void update_disagreement(const Latent& z, const Readings& y, const Estimate& x_hat) {
    for (int i = 0; i < kNx; ++i) {
      if (!(model_->per_row_deviation[i] > Scalar(0))) {
        state_.disagreement[i] = 0;
        continue;
      }
      Scalar off = multiply_add(x_hat[i], model_->per_row_deviation[i], -model_->row_offset[i]);
      for (int r = 0; r < kNz; ++r) off = multiply_add(-model_->row[i][r], z[r], off);
      for (int k = 0; k < kNr; ++k) off = multiply_add(-model_->row[i][kNz + k], y[k], off);
      off = limited(off < Scalar(0) ? -off : off, Scalar(kLargestInnovation * kLargestInnovation));
      Scalar& mean = state_.disagreement[i];
      mean = multiply_add(model_->gain[Model::kWindows > 1 ? 1 : 0], off - mean, mean);
    }
  }

  template <class Latent, class Readings>
  constexpr void predict(const Latent& z, const Readings& y, const Estimate& x_hat) {
    for (int j = 0; j < kNy; ++j) {
      const auto& row = model_->prediction[j];
      Scalar sum = model_->offset[j];
      for (int r = 0; r < kNz; ++r) sum = multiply_add(row[r], z[r], sum);
      for (int i = 0; i < kNr; ++i) sum = multiply_add(row[kNz + i], y[i], sum);
      for (int i = 0; i < kNx; ++i) sum = multiply_add(row[kNz + kNr + i], x_hat[i], sum);
      state_.outputs[j].predicted = limited(sum, kFar);
      state_.outputs[j].y = y[j];
    }
  }

  /// Finds the largest ratio of a statistic to its limit. Returns false if no samples can have produced the statistics:
  /// a value that is far too large or NaN shows in their sum. A smaller corruption may raise an alarm. It then decays
  /// like an old innovation.
  constexpr bool judge() {
    constexpr Scalar kMostTogether = kMostSquare * Scalar(Model::kWindows * (3 * kNy + 1) + kNy + kNx);
    Scalar worst = 0, together = 0;
    Alarm why = Alarm::kNone;
    const auto ask = [&](Scalar value, Scalar limit, Alarm alarm) {
      // value / limit > worst without a division for each
      if (!(value > worst * limit)) return;
      worst = value / limit;
      why = alarm;
    };
    for (int j = 0; j < kNy; ++j) {
      const OutputState& own = state_.outputs[j];
      together += own.missing_share;
      ask(own.missing_share, model_->missing_limit[j], Alarm::kMissing);
    }
    const bool missing = worst > Scalar(1);  // raises an alarm even before the monitor is armed
    for (int j = 0; j < kNy; ++j) {
      const OutputState& own = state_.outputs[j];
      for (int w = 0; w < Model::kWindows; ++w) {
        const Window& window = own.windows[w];
        const Scalar least = model_->least_variance[j];
        const Scalar noise = window.variance > least ? window.variance : least;
        const Scalar correlation = window.correlation < Scalar(0) ? -window.correlation : window.correlation;
        together += window.power + window.variance + correlation;
        ask(window.power / noise, model_->mean_limit[j][w], Alarm::kInnovationMean);
        ask(window.variance, model_->variance_limit[j][w], Alarm::kInnovationVariance);
        ask(correlation, model_->correlation_limit[j][w], Alarm::kInnovationCorrelation);
      }
    }
    for (int w = 0; w < Model::kWindows; ++w) {
      together += state_.distance[w];
      ask(state_.distance[w], model_->latent_limit[w], Alarm::kLatentDistance);
    }
    for (int i = 0; i < kNx; ++i) {
      together += state_.disagreement[i];
      if (model_->disagreement_limit[i] > Scalar(0))
        ask(state_.disagreement[i], model_->disagreement_limit[i], Alarm::kDisagreement);
    }
    state_.level = worst;
    if (!armed()) why = missing ? Alarm::kMissing : Alarm::kNone;
    state_.alarm = worst > Scalar(1) ? why : Alarm::kNone;
    return is_below(together, kMostTogether) && state_.samples >= 0 && state_.samples <= model_->armed_after + 1;
  }

  const Model* model_;
  State state_{};
};

}  // namespace nlo::inline NLO_ISA
