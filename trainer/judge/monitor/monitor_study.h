// SPDX-License-Identifier: MIT
// Detections of a monitor under conditions that differ from the training, and the effect of its gate there.
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

/// Alarms of runs: one is counted, and none more until a time constant has passed without.
struct AlarmCount {
  double seen = 0.0;                     ///< share of the runs with an alarm within five time constants of being armed
  std::optional<double> median_delay_s;  ///< from being armed to the first alarm, over the runs that have one
  double per_hour = 0.0;
  nlo::Alarm most = nlo::Alarm::kNone;  ///< the commonest first alarm
};
AlarmCount count_alarms(const std::vector<codegen::WatchedRun>& runs, double sample_period_s, double time_constant_s);

struct MonitorRow {
  std::string condition;
  double error = 0.0;     ///< norm of x - x_hat once armed, without the gate
  double ratio = 0.0;     ///< over that of the first row
  double gated = 0.0;     ///< norm behind the gate
  double rejected = 0.0;  ///< share of the measurements that were beyond it
  AlarmCount alarms;
};

struct MonitorStudy {
  double time_constant_s = 0.0, horizon_s = 0.0;
  int runs = 0;                         ///< of each condition
  std::vector<MonitorRow> rows;         ///< the first is as in training
  std::vector<std::string> left_out;    ///< conditions that the plant has no parameters for
  std::vector<std::string> impossible;  ///< conditions that the plant cannot take, with the reason
  std::vector<FaultRow> faults;         ///< of each output

  std::optional<AlarmCount> on_logs = {};  ///< on logs that limits were not set on ...
  double log_hours = 0.0;                  ///< ... so many hours
};

/// `trained`: the sensors of the training; `set`: the conditions. Each condition has `runs` runs of its own, of eight
/// time constants at least; the first row as many as make `hours` hours, to count false alarms on.
MonitorStudy study_monitor(const codegen::Model& model, const Experiment& experiment, const Condition& trained,
                           const ConditionSet& set, double time_constant_s, int runs, double hours, std::uint64_t seed,
                           int threads, const MonitorProgress& progress = {});

/// Counts alarms and tries faults on logs that set no limit. Empty without any.
MonitorStudy study_on_logs(const codegen::Model& model, const Dataset& logs, int threads);

}  // namespace nlo::trainer
