// SPDX-License-Identifier: MIT
// Alarms of a monitor under conditions that differ from the training, and the effect of its gate there.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "codegen/replay/reference_monitor.h"
#include "trainer/config/experiment.h"
#include "trainer/judge/compare/conditions.h"
#include "trainer/judge/monitor/fault_trial.h"
#include "trainer/judge/monitor/fit_monitor.h"

namespace nlo::trainer {

/// Alarms of runs. After an alarm, the next one counts only after a time constant without an alarm.
struct AlarmCount {
  double seen = 0.0;                     ///< share of the runs with an alarm within five time constants after arming
  std::optional<double> median_delay_s;  ///< from arming to the first alarm, over the runs with an alarm
  double per_hour = 0.0;
  nlo::Alarm most = nlo::Alarm::kNone;  ///< most frequent first alarm
};
AlarmCount count_alarms(const std::vector<codegen::WatchedRun>& runs, double sample_period_s, double time_constant_s);

struct MonitorRow {
  std::string condition;
  double error = 0.0;     ///< norm of x - x_hat once armed, without the gate
  double ratio = 0.0;     ///< error / error of the first row
  double gated = 0.0;     ///< norm with the gate
  double rejected = 0.0;  ///< share of the measurements that the gate rejected
  AlarmCount alarms;
};

struct MonitorStudy {
  double time_constant_s = 0.0, horizon_s = 0.0;
  int runs = 0;                         ///< number of runs of each condition
  std::vector<MonitorRow> rows;         ///< the first row is as in training
  std::vector<std::string> left_out;    ///< conditions on parameters that the plant does not have
  std::vector<std::string> impossible;  ///< conditions under which the plant cannot be simulated, with the reason
  std::vector<FaultRow> faults;         ///< faults of each output

  std::optional<AlarmCount> on_logs = {};  ///< alarms on logs that were not used for the limits
  double log_hours = 0.0;                  ///< length of these logs [h]
};

/// `trained`: the sensors of the training; `set`: the conditions. Each condition has `runs` runs of at least eight time
/// constants. The first row has as many runs as fill `hours` hours, to count false alarms.
MonitorStudy study_monitor(const codegen::Model& model, const Experiment& experiment, const Condition& trained,
                           const ConditionSet& set, double time_constant_s, int runs, double hours, std::uint64_t seed,
                           int threads, const MonitorProgress& progress = {});

/// Counts alarms and tries faults on logs that were not used for the limits. Empty without such logs.
MonitorStudy study_on_logs(const codegen::Model& model, const Dataset& logs, int threads);

}  // namespace nlo::trainer
