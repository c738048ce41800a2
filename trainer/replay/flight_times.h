// SPDX-License-Identifier: MIT
// The time column of a flight's log: in whatever unit, as seconds between its rows.
#pragma once

#include <Eigen/Core>

#include "trainer/replay/flight_log.h"

namespace nlo::trainer {

/// Seconds since the row before, N (the first: `stepped_s` of it), of stamps `time` (N, NaN: none there) in s, ms, us,
/// ns or a unit that is found by the flight itself: `stepped_s` (N) is what each step was over. Empty where the stamps
/// do not follow the steps: too coarse, not of the loop, or of a few rows only.
Eigen::VectorXd seconds_between(const Eigen::VectorXd& time, const Eigen::VectorXd& stepped_s);

/// What the time of a log says of its steps.
class StepTimes {
 public:
  /// The rows before `right` were stepped as the log says: what their stamps are off by is jitter.
  StepTimes(const FlightLog& log, double sample_period_s, Eigen::Index right);

  /// Another time has passed before `row` than was stepped over. False without a time.
  bool off(Eigen::Index row) const;
  /// How many whole sample periods more; 0: none, or no whole number.
  Eigen::Index lost(Eigen::Index row) const;
  /// Sample periods that have passed, rounded.
  Eigen::Index passed(Eigen::Index row) const;

 private:
  double beyond(Eigen::Index row) const;

  const FlightLog& log_;
  double period_s_, off_;
};

}  // namespace nlo::trainer
