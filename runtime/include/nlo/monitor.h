// SPDX-License-Identifier: MIT
// Says when an observer is wrong: a plant that is not the one of the training, a sensor that is worse, a state where
// training never was. What it watches is the innovation, by how much each output differs from what the sample before
// let expect, and where z is:
//
//   e_j = (dy_j - P_j [z - S y; y; x_hat] - c_j) / deviation_j      dy_j: change of output j since the last sample
//   m <- m + a (e - m),  v <- v + a (e^2 - v),  r <- r + a (e e_last - r)      a = 1 - exp(-period / window)
//   p <- p + a_longest (m^2 - p)                 power of the smoothed innovation: what is off, either way and how long
//   d <- d + a (mean of ((z - S y - mean) / deviation)^2 - d)
//   q_j <- q_j + a (missing_j - q_j)                                over the first window
//
// Alarm while one of p / max(v, least_variance), v, |r|, d, q is above its limit. Limits come from runs like those of
// the training, for a stated number of false alarms per hour (nlo monitor). Each e counts as kLargest at most, so that
// one outlier raises no alarm.
//
// It also keeps outliers from the observer: an output whose |e| is beyond the gate is not taken, unless the sensor is
// as noisy as that (the gate widens with sqrt(v)) or it happens often in a row. Nor is a sensor taken that is frozen:
// it repeats one reading for longer than those of the training, unless it rests and another output, its witness, does.
//
// No heap, no exceptions, no libm; whatever arrives, all of it stays finite: statistics that are outside of what steps
// can lead to, or not numbers, come of a bit of memory that has flipped, and are an alarm of their own, kReset, with
// which it begins again. It counts samples: steps may jitter as they did in training; after a gap, reset().
#pragma once

#include <cstdint>
#include <limits>

#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"
#include "nlo/measurement.h"
#include "nlo/monitor_model.h"
#include "nlo/vector.h"

namespace nlo {

/// Deterministic arithmetic, the same bits on every target, is one more word, as for KklObserver.
template <class Model_, Arithmetic kArithmetic = Arithmetic::kFast>
class Monitor {
 public:
  using Model = Model_;
  using Scalar = typename Model::Scalar;
  static constexpr int kNx = Model::kNx, kNy = Model::kNy, kNz = Model::kNz, kNr = Model::kNr;
  using Output = Vector<Scalar, kNy>;
  /// Outputs that are measured: fewer where the observer computes some of the others.
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
    Scalar y, predicted, last;  // the last reading, the change foreseen from there [deviations], the last innovation
    Scalar missing_share;
    Scalar raw;             // the last measurement that was one, whether it was taken or not
    std::uint16_t equal;    // measurements in a row that repeat it, and not because of rest
    std::uint8_t rejected;  // in a row
    std::uint8_t missing;   // of the sample that watch() sees next; no bool: a flipped bit may make any byte of it
  };
  /// All of a monitor that changes.
  struct State {
    OutputState outputs[kNy];
    Scalar distance[Model::kWindows];
    Scalar level;
    int samples;  // since the start, until armed
    Alarm alarm;
  };

  /// The model must outlive the monitor; generated models are constants.
  constexpr explicit Monitor(const Model& model) : model_(&model) { reset(); }
  explicit Monitor(const Model&&) = delete;

  /// After a gap. With the observer's reset() too, unless trusted() or watch() sees it before its next measurement.
  constexpr void reset() {
    state_ = State{};
    for (auto& output : state_.outputs)
      for (Window& window : output.windows) window.variance = 1;
    for (Scalar& distance : state_.distance) distance = 1;
  }

  /// The measurements as `observer` should be given them: those beyond the gate or of a frozen sensor are not-a-number,
  /// which it holds. For the sample that watch() sees next.
  template <class Observer>
  [[nodiscard]] constexpr Measured<Observer> trusted(Measured<Observer> y, const Observer& observer) {
    const bool first = observer.save().started != 1;  // what comes is its first measurement
    if (first) reset();
    for (int j = 0; j < kMeasured<Observer>; ++j) {
      OutputState& own = state_.outputs[j];
      own.missing = !is_finite(y[j]);
      if (own.missing == 1) continue;
      count_repeats(own, j, y[j], y[model_->witness[j]]);
      if (first || state_.samples == 0) continue;
      const Scalar e = innovation(j, y[j], observer.model().outputs.wrap[j]);
      const Scalar noise = own.windows[0].variance > Scalar(1) ? own.windows[0].variance : Scalar(1);
      const bool beyond = e * e > model_->gate_squared * noise && own.rejected < kMostRejected;
      own.missing = beyond || is_frozen(own, j);
      own.rejected = static_cast<std::uint8_t>(own.missing == 1 ? own.rejected + (own.rejected < kMostRejected) : 0);
      if (own.missing == 1) y[j] = std::numeric_limits<Scalar>::quiet_NaN();
    }
    for (int j = kMeasured<Observer>; j < kNy; ++j) {  // computed: of what may be missing
      state_.outputs[j].missing = 0;
      for (const Scalar measured : y) state_.outputs[j].missing |= static_cast<std::uint8_t>(!is_finite(measured));
    }
    return y;
  }
  template <class Observer>
  [[nodiscard]] constexpr Scalar trusted(Scalar y, const Observer& observer) requires(kMeasured<Observer> == 1) {
    return trusted(Measured<Observer>{{y}}, observer)[0];
  }
  template <class Y, class Observer>
  [[deprecated("it is called trusted()")]] [[nodiscard]] constexpr auto screened(const Y& y, const Observer& observer) {
    return trusted(y, observer);
  }

  /// After each step of `observer`, with its estimate of the same sample. kReset where that step has reset the
  /// observer, or what the monitor remembers is not what it can have seen.
  template <class Observer>
  [[nodiscard]] constexpr Alarm watch(const Observer& observer, const Estimate& x_hat) {
    static_assert(Observer::kNz == kNz && Observer::kNr == kNr && Observer::kNx == kNx, "the monitor of another model");
    const auto taken = observer.save();
    if (taken.started != 1)  // it has seen nothing yet
      return begin_again(taken.status == StepStatus::kReset ? Alarm::kReset : Alarm::kNone);
    const auto& y = taken.y;  // readings: held, clamped, angles within a turn
    const auto z = observer.relative_latent();
    if (state_.samples > 0) {
      for (int j = 0; j < kNy; ++j)
        if (state_.outputs[j].missing == 0)
          take(state_.outputs[j], innovation(j, y[j], observer.model().outputs.wrap[j]));
    }
    note_place(z);
    predict(z, y, x_hat);
    if (state_.samples <= model_->armed_after) ++state_.samples;
    return judge() ? state_.alarm : begin_again(Alarm::kReset);
  }

  /// It has seen as many samples as it takes to tell: before, watch() says kNone whatever the level. Not so after the
  /// observer's reset(), from the next trusted() or watch() on.
  [[nodiscard]] constexpr bool armed() const { return state_.samples > model_->armed_after; }

  [[nodiscard]] constexpr State save() const { return state_; }

  /// Continues from a saved state, beside the observer's restore(). Refused (false,
  /// nothing changed) unless watching can reach it.
  [[nodiscard]] constexpr bool restore(const State& saved) {
    if (!is_reachable(saved)) return false;
    state_ = saved;
    return true;
  }

  /// What watch() said last.
  [[nodiscard]] constexpr Alarm alarm() const { return state_.alarm; }

  /// The largest of the statistics over its limit: above 1, alarm. 0 after kReset.
  [[nodiscard]] constexpr Scalar level() const { return state_.level; }

 private:
  static constexpr Scalar kFar = Scalar(1e6);  // deviations; its square is finite
  // An average stays within what is averaged, and its roundings.
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
    for (const OutputState& own : state.outputs) {
      good = good && is_finite(own.y) && within(own.predicted, kFar) && within(own.last, Scalar(kLargestInnovation)) &&
             within(own.missing_share, Scalar(1.01)) && is_finite(own.raw) && own.rejected <= kMostRejected &&
             own.missing <= 1;
      for (const Window& window : own.windows)
        good = good && within(window.mean, kMostSquare) && within(window.power, kMostSquare) &&
               within(window.variance, kMostSquare) && within(window.correlation, kMostSquare);
    }
    return good;
  }

  constexpr bool is_frozen(const OutputState& own, int j) const {
    return model_->most_equal[j] > 0 && own.equal >= model_->most_equal[j];
  }

  /// Counts measurements that are the same to the bit, but those of a sensor at rest: until it is frozen.
  constexpr void count_repeats(OutputState& own, int j, Scalar y, Scalar witness) const {
    const bool moves = witness < model_->rest_min[j] || witness > model_->rest_max[j];  // not so of a missing one
    const bool at_rest = y == model_->resting[j] && !moves && !is_frozen(own, j);
    own.equal = static_cast<std::uint16_t>(y != own.raw || at_rest ? 0 : own.equal + (own.equal < 65535));
    own.raw = y;
  }

  static constexpr Scalar limited(Scalar value, Scalar largest) {  // not-a-number too
    const Scalar below = value < largest ? value : largest;
    return below > -largest ? below : -largest;
  }

  static constexpr Scalar multiply_add(Scalar a, Scalar b, Scalar c) { return nlo::multiply_add<kArithmetic>(a, b, c); }

  constexpr Scalar innovation(int j, Scalar y, Scalar turn) const {
    const OutputState& own = state_.outputs[j];
    Scalar change = y - own.y;
    if (turn > Scalar(0)) change = ReadingRange<Scalar, 1>::template wrapped<kArithmetic>(change, turn);
    return limited(multiply_add(change, model_->per_deviation[j], -own.predicted), kFar);
  }

  constexpr void take(OutputState& own, Scalar innovation) {
    const Scalar e = limited(innovation, Scalar(kLargestInnovation));
    for (int w = 0; w < Model::kWindows; ++w) {
      Window& window = own.windows[w];
      const Scalar gain = model_->gain[w];
      window.mean = multiply_add(gain, e - window.mean, window.mean);
      window.power = multiply_add(model_->gain[Model::kWindows - 1],
                                  multiply_add(window.mean, window.mean, -window.power), window.power);
      window.variance = multiply_add(gain, multiply_add(e, e, -window.variance), window.variance);
      window.correlation = multiply_add(gain, multiply_add(e, own.last, -window.correlation), window.correlation);
    }
    own.last = e;
  }

  template <class Latent>
  constexpr void note_place(const Latent& z) {
    Scalar sum = 0;
    for (int r = 0; r < kNz; ++r) {
      const Scalar off = limited((z[r] - model_->latent_mean[r]) * model_->per_latent_deviation[r], kFar);
      sum = multiply_add(off, off, sum);
    }
    const Scalar mean = limited(sum * (Scalar(1) / Scalar(kNz)), Scalar(kLargestInnovation * kLargestInnovation));
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

  /// False: the statistics are not what samples can lead to. One that is far out, or not a number, is so in their sum,
  /// too; one that is so by less has been an alarm, and is forgotten as innovations are.
  constexpr bool judge() {
    constexpr Scalar kMostTogether = kMostSquare * Scalar(Model::kWindows * (3 * kNy + 1) + kNy);
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
      together += own.missing_share;
      ask(own.missing_share, model_->missing_limit[j], Alarm::kMissing);
    }
    for (int w = 0; w < Model::kWindows; ++w) {
      together += state_.distance[w];
      ask(state_.distance[w], model_->latent_limit[w], Alarm::kLatentDistance);
    }
    state_.level = worst;
    state_.alarm = worst > Scalar(1) && armed() ? why : Alarm::kNone;
    return is_below(together, kMostTogether) && state_.samples >= 0 && state_.samples <= model_->armed_after + 1;
  }

  const Model* model_;
  State state_{};
};

}  // namespace nlo
