// SPDX-License-Identifier: MIT
// Evaluates the observer on logs of a real rig, with estimates that need no observer for comparison.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/base/noise.h"
#include "trainer/data/dataset.h"
#include "trainer/data/log_metrics.h"
#include "trainer/data/log_schema.h"
#include "trainer/judge/evaluation/evaluate.h"
#include "trainer/judge/evaluation/evaluation_study.h"
#include "trainer/judge/evaluation/metrics.h"
#include "trainer/judge/evaluation/sensor_fault.h"
#include "trainer/judge/filters/step_cost.h"

namespace nlo::trainer {

/// Samples without weight.
struct Unscored {
  double share = 0.0;
  std::string where;  ///< "the first 0.2 s and the last 0.2 s of each log"; empty if all samples count
};

/// An estimator on logs.
struct LogEntry {
  std::string estimator;  ///< "observer", "ekf", one of LogBaseline::names(), "ridge" ...
  /// Description of a baseline for each state. An empty text: it does not apply to the state. An empty list: this
  /// estimator is not a baseline.
  std::vector<std::string> describe;
  LogMetrics metrics;      ///< NaN for a state to which it does not apply
  StepCost cost = {};      ///< {0, 0}: not counted
  std::string setup = {};  ///< tuning of a filter, in words
};

/// Adds each of LogBaseline::names() that applies to a state, fitted on `training`, evaluated on `judged`.
///   wanted  called before each name; if it returns false, the name is left out
void judge_baselines(std::vector<LogEntry>& entries, const Dataset& training, const Dataset& judged,
                     const LogSchema& schema, const std::vector<AnglePair>& angles, const EvaluationWindows& windows,
                     const std::function<bool(const std::string& name)>& wanted);

/// Conditions of the observer's flight over a log.
struct LogFlight {
  std::vector<SensorFault> faults = {};
  bool behind_gate = false;  ///< true: outputs pass the gate of the model's monitor, which it must have
};

struct LogEvaluation {
  std::vector<LogEntry> entries;  ///< the observer first, then baselines and "ridge"
  ErrorMetrics metrics;           ///< metrics of the observer over all files
  /// Notes on states that a constant or a linear readout estimates as well, and on implausible estimates where nothing
  /// is scored.
  std::vector<std::string> notes;
  Unscored unscored;
  std::vector<std::string> unscored_states = {};  ///< states of the model for which the logs have no truth
  DomainShare domain;
  std::optional<Coverage> coverage = {};          ///< coverage of the intervals of a model with an error head
  std::optional<Coverage> widened_coverage = {};  ///< the same intervals, widened by the monitor
  NoiseConfig noise;                              ///< noise that was added to the logged outputs
  std::vector<std::string> missing = {};          ///< outputs that were removed, and how
  bool behind_gate = false;                       ///< true: outputs passed the gate of the model's monitor
  std::uint64_t seed = 0;
  std::string split;                     ///< "test", "validation" or "training" of an experiment; empty: other logs
  std::string baselines_fitted_on;       ///< "the training logs", "these logs, in hindsight"
  std::vector<Channel> states, outputs;  ///< states: only those that are scored
  std::vector<EvaluatedRun> examples;  ///< all logs, or kMostExamples of them (examples.h); the first log is the first
                                       ///< example
};

/// Runs the model and the baselines over every log, with `noise` added to the measured outputs.
///   logs, schema   have all of the model's outputs and inputs, and the truth of at least one state; the other states
///   are unscored
///   baseline_logs  data for fitting the baselines: the training logs; or nullptr: the tested logs, in hindsight, which
///   makes the baselines harder to beat
///   flight         sensors that fail. The ridge regression does not read a missing output, and all other alternatives
///   except the constant are left out. No estimator is told about stuck or dead sensors
///   config         windows of the errors; state_scale is set here if the states' units differ
LogEvaluation evaluate_on_logs(const codegen::Model& model, const Dataset& logs, const LogSchema& schema,
                               const Dataset* baseline_logs, const NoiseConfig& noise, std::uint64_t seed,
                               MetricsConfig config = {}, const StudyProgress& progress = {},
                               const LogFlight& flight = {});

/// Returns the share and the place of the samples that have no weight.
Unscored find_unscored(const Dataset& logs);

/// Returns a note for each state whose estimate at an unscored sample leaves the range of the truth on all scored
/// samples, widened by half of that range on either side. The note has the farthest estimate. Angles have no range.
std::vector<std::string> unscored_notes(const Dataset& logs, const std::vector<Eigen::MatrixXd>& estimates);

}  // namespace nlo::trainer
