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
  double false_alarms_per_hour = 1.0;  ///< half of one in a time constant at most
  double time_constant_s = 1.0;        ///< averages over a quarter of it, over it, and over twice it
  int threads = 0;                     ///< 0: all cores; the result does not depend on it
};

/// Called with the share that is done.
using MonitorProgress = std::function<void(double share)>;

/// A monitor with its properties before flight.
struct FittedMonitor {
  codegen::Monitor monitor;
  GateReport gate;
  std::vector<std::string> notes;      ///< lines on the time constant and the rate, where they are unusual
  std::vector<std::string> unwatched;  ///< statistics whose limit they cannot reach, or that training itself reaches
};

/// Makes a monitor.
///   fit     runs that predictions, deviations, the linear fit of T* and the gate are fitted to
///   limits  hours of other runs: each statistic's largest value in each time constant; the rate of those above a limit
///           is an exponential tail beyond the largest 0.5 %. All limits are then scaled together, so that the alarm
///           that any of them gives has the rate.
///   clean   runs without noise, where there is a plant: prediction errors smaller than theirs tell nothing
///   trial   runs that set nothing but when the monitor arms: once the error of x_hat is at most twice its later size,
///           after one time constant at least and three at most. A gate that does harm there is not shipped
///           (gate_trial.h).
/// Throws codegen::Error when runs are too few or too short.
FittedMonitor fit_monitor(const codegen::Model& model, const SensedRuns& fit, const RunSource& limits,
                          const std::optional<SensedRuns>& clean, const std::vector<FlownRun>& trial,
                          const MonitorRequest& request, const MonitorProgress& progress = {});

/// Returns the value that is exceeded `per_hour` times an hour, by the exponential tail beyond the largest 0.5 % (20 at
/// least) of `values`. Each value is the largest of a block; all blocks together last `hours`.
double exceeded_at_rate(std::vector<double> values, double hours, double per_hour);

}  // namespace nlo::trainer
