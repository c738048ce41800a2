// SPDX-License-Identifier: MIT
// Makes a monitor (nlo/monitor.h) from runs like those of the training: predictions of the next outputs, and limits
// that are exceeded at a stated rate.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/judge/monitor/flown_runs.h"
#include "trainer/judge/monitor/gate_trial.h"
#include "trainer/judge/monitor/sensed_runs.h"

namespace nlo::trainer {

struct MonitorRequest {
  double false_alarms_per_hour = 1.0;  ///< at most half of one per time constant
  double time_constant_s = 1.0;        ///< T; the statistics average over T / 4, T and 2 T
  int threads = 0;                     ///< 0: all cores; the result does not depend on it
};

/// Called with the finished share of the work.
using MonitorProgress = std::function<void(double share)>;

/// A monitor and its properties before flight.
struct FittedMonitor {
  codegen::Monitor monitor;
  GateReport gate;
  std::vector<std::string> notes;  ///< lines on the time constant, the rate and the arming, if they are unusual
  /// Statistics that are not watched, because they cannot reach their limit, or reach it in training.
  std::vector<std::string> unwatched;
};

/// Makes a monitor.
///   fit     runs for the fit of predictions, deviations, the linear fit of T* and the gate
///   limits  hours of other runs: the largest value of each statistic in each time constant. The rate above a limit
///   follows an exponential tail beyond the largest 0.5 %. All limits are then scaled together, so that all alarms
///   together have the stated rate
///   clean   runs without noise, if there is a plant: smaller prediction errors are not significant
///   trial   runs that only set the arming time: after starts and after restarts in the middle of the runs, x_hat must
///   have at most twice its settled error. The time is at least one time constant. At most, it is three time constants
///   or half of the shortest run, whichever is longer. A gate that increases the error on them is not shipped
///   (gate_trial.h)
/// Throws codegen::Error if runs are too few or too short.
FittedMonitor fit_monitor(const codegen::Model& model, const SensedRuns& fit, const RunSource& limits,
                          const std::optional<SensedRuns>& clean, const std::vector<FlownRun>& trial,
                          const MonitorRequest& request, const MonitorProgress& progress = {});

/// Returns the value that is exceeded `per_hour` times an hour, by the exponential tail beyond the largest 0.5 % (at
/// least 20) of `values`. Each value is the largest of a block; all blocks together last `hours`.
double exceeded_at_rate(std::vector<double> values, double hours, double per_hour);

}  // namespace nlo::trainer
