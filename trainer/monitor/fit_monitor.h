// SPDX-License-Identifier: MIT
// A monitor (nlo/monitor.h) from runs like those of the training: what the next outputs are expected to be, and limits
// that are passed at a stated rate.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/monitor/sensed_runs.h"

namespace nlo::trainer {

struct MonitorRequest {
  double false_alarms_per_hour = 1.0;
  double time_constant_s = 1.0;  ///< averages over a quarter of it, over it, and over twice it; armed after one
  int threads = 0;               ///< 0: all cores; the result does not depend on it
};

/// Called with the share that is done.
using MonitorProgress = std::function<void(double share)>;

///   fit     predictions, deviations and the gate, by least squares
///   limits  hours of other runs: each statistic's largest value in each time constant; the rate of those above a limit
///           is an exponential tail beyond the largest 0.5 %. All limits are then scaled together, so that the alarm
///           that any of them gives has the rate.
///   clean   runs without noise, where there is a plant: below them an error of prediction is no news
/// Throws codegen::Error when runs are too few or too short.
codegen::Monitor fit_monitor(const codegen::Model& model, const SensedRuns& fit, const RunSource& limits,
                             const std::optional<SensedRuns>& clean, const MonitorRequest& request,
                             const MonitorProgress& progress = {});

/// The value that is exceeded `per_hour` times an hour, by the exponential tail beyond the largest 0.5 % (20 at least)
/// of `values`, each the largest of a block, which are `hours` long together.
double exceeded_at_rate(std::vector<double> values, double hours, double per_hour);

}  // namespace nlo::trainer
