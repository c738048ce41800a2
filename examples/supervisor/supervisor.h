// SPDX-License-Identifier: MIT
// Runs an observer beside your own filter, for example an EKF. Both step at every sample. The loop gets the observer's
// estimate while the observer is trusted, otherwise the filter's. The estimate for the loop does not jump when they
// change:
//
//   x_hat_k = active_k + offset_k
//   offset_k = fade offset_{k-1}              at a hand-over: offset_k = (x_hat of the estimator before) - active_k
//
// No heap, no exceptions. Copy this file, and change the conditions for distrusting your observer: speaks_against().
#pragma once

#include <nlo/monitor.h>

#include <cstdint>

namespace nlo::examples {

enum class Source : std::uint8_t { kObserver, kFilter };

struct SupervisorConfig {
  int patience = 3;     ///< distrusted samples in a row before the filter takes over
  int probation = 250;  ///< trusted samples in a row before the observer takes over again
  double fade = 0.98;   ///< share of the offset that remains after one sample, exp(-sample period / time constant)
};

/// Filter has   void step(const Output& y)       gets the measurement unchanged, also NaN
///              Estimate estimate() const        returns n_x values, finite while the filter can be used
/// Observer and Monitor are those of an exported header. All three must outlive the supervisor.
template <class Observer, class Monitor, class Filter>
class Supervisor {
 public:
  using Estimate = typename Monitor::Estimate;
  using Output = typename Monitor::template Measured<Observer>;
  using Scalar = typename Monitor::Scalar;

  constexpr Supervisor(Observer& observer, Monitor& monitor, Filter& filter, const SupervisorConfig& config = {})
      : observer_(observer), monitor_(monitor), filter_(filter), config_(config) {}

  /// Steps both by one sample and returns the estimate for the loop. It is finite if one of both estimates is;
  /// otherwise the last finite one is returned.
  Estimate step(const Output& y) {
    const StepStatus status = observer_.step(monitor_.usable_outputs(y, observer_));
    filter_.step(y);
    const Estimate observed = observer_.estimate(), filtered = filter_.estimate();
    alarm_ = monitor_.watch(observer_, observed);
    if (status == StepStatus::kReset) monitor_.reset();

    const bool lost = !is_finite_estimate(observed) || status == StepStatus::kStale ||
                      status == StepStatus::kOutOfRange || status == StepStatus::kDiverged ||
                      status == StepStatus::kReset;
    const bool against = lost || speaks_against(alarm_, observer_.in_domain());
    against_ = against ? next_count(against_) : 0;
    clean_ = against ? 0 : next_count(clean_);

    Source wanted = source_;
    if (source_ == Source::kObserver && (lost || against_ >= config_.patience)) wanted = Source::kFilter;
    if (source_ == Source::kFilter && clean_ >= config_.probation) wanted = Source::kObserver;
    if (wanted == Source::kFilter && !is_finite_estimate(filtered) && !lost) wanted = Source::kObserver;

    const Estimate active = wanted == Source::kObserver ? observed : filtered;
    const Estimate before = source_ == Source::kObserver ? observed : filtered;
    const bool changes = wanted != source_;
    source_ = wanted;
    if (!is_finite_estimate(active)) return last_;
    const bool continues = is_finite_estimate(before);
    Estimate x_hat;
    for (int i = 0; i < Monitor::kNx; ++i) {
      offset_[i] *= static_cast<Scalar>(config_.fade);
      if (changes && started_) offset_[i] = (continues ? before[i] + offset_[i] : last_[i]) - active[i];
      x_hat[i] = active[i] + offset_[i];
    }
    started_ = true;
    return last_ = x_hat;
  }

  [[nodiscard]] constexpr Source source() const { return source_; }
  [[nodiscard]] constexpr Alarm alarm() const { return alarm_; }
  [[nodiscard]] constexpr Estimate offset() const { return offset_; }

 private:
  static constexpr bool speaks_against(Alarm alarm, bool in_domain) { return alarm != Alarm::kNone || !in_domain; }

  static constexpr bool is_finite_estimate(const Estimate& x_hat) {
    bool finite = true;
    for (int i = 0; i < Monitor::kNx; ++i) finite = finite && is_finite(x_hat[i]);
    return finite;
  }

  static constexpr int next_count(int count) { return count < 1'000'000'000 ? count + 1 : count; }

  Observer& observer_;
  Monitor& monitor_;
  Filter& filter_;
  SupervisorConfig config_;
  Source source_ = Source::kObserver;
  Alarm alarm_ = Alarm::kNone;
  int against_ = 0, clean_ = 0;
  bool started_ = false;
  Estimate offset_{}, last_{};
};

}  // namespace nlo::examples
