// SPDX-License-Identifier: MIT
// The result of a run: the strict test on its plant, or its test logs; printed, and as report.html.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"
#include "trainer/data/log_dataset.h"
#include "trainer/judge/compare/study.h"
#include "trainer/judge/evaluation/evaluate.h"
#include "trainer/judge/evaluation/evaluate_logs.h"
#include "trainer/learn/training/readout.h"

namespace nlo::trainer {

struct RunReport {
  std::vector<StudyRow> rows;         ///< for a plant: one per noise
  std::optional<LogEvaluation> logs;  ///< result on the test logs
  std::optional<LogReport> log_clock;
  Readout readout = {};                          ///< readout of each state
  bool readout_by_settled = false;               ///< its errors are those of settled samples
  std::size_t groups = 0;                        ///< groups of logs, left out of trainings, that chose it
  std::vector<std::string> derived_states = {};  ///< whose truth is the slope of another column
  std::string warning = {};                      ///< why not to trust this model: its training diverged or got nowhere
};

/// A plant: `test`; without conditions in it, no noise and that of the training.
RunReport report_on_plant(const codegen::Model& model, const Experiment& experiment, StudyTest test);

/// The logs that judge a model: the test split; without one the validation split, without that the training split.
struct ReportedLogs {
  const Dataset& logs;
  std::string split;  ///< "test", "validation" or "training"
};
ReportedLogs logs_to_report_on(const LogSplits& splits);

/// Logs, beside baselines that learn from the training split. A note says so when they are not test logs.
RunReport report_on_logs(const codegen::Model& model, const Experiment& experiment, const Dataset& training,
                         const ReportedLogs& judged, const LogReport& clock);

/// Tables for a terminal.
std::string run_report_text(const codegen::Model& model, const RunReport& report);

/// report.html of a run that lies in `directory`.
std::string run_report_page(const codegen::Model& model, const RunReport& report, const std::string& directory);

/// Replaces DIR/report.html by it.
void write_run_report(const codegen::Model& model, const RunReport& report, const std::string& directory);

}  // namespace nlo::trainer
