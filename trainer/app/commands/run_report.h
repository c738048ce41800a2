// SPDX-License-Identifier: MIT
// The result of a run: the strict test on its plant or its test logs, printed and as report.html.
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
  bool readout_by_settled = false;               ///< true: the readout was chosen by the errors of settled samples
  std::size_t groups = 0;                        ///< number of left-out groups of logs whose errors chose the readout
  std::vector<std::string> derived_states = {};  ///< states whose truth is the slope of another column
  std::string warning = {};  ///< reason not to trust this model: its training diverged or did not improve its start
};

/// Tests the model on its plant. If `test` has no conditions, these are no noise and the noise of the training.
RunReport report_on_plant(const codegen::Model& model, const Experiment& experiment, StudyTest test);

/// Returns the logs for the test of a model: the test split; otherwise the validation split; otherwise the training
/// split.
struct ReportedLogs {
  const Dataset& logs;
  std::string split;  ///< "test", "validation" or "training"
};
ReportedLogs logs_to_report_on(const LogSplits& splits);

/// Tests the model on logs, with baselines that learn from the training split. A note says if they are not test logs.
RunReport report_on_logs(const codegen::Model& model, const Experiment& experiment, const Dataset& training,
                         const ReportedLogs& judged, const LogReport& clock);

/// Returns tables for a terminal.
std::string run_report_text(const codegen::Model& model, const RunReport& report);

/// Returns report.html of a run in `directory`.
std::string run_report_page(const codegen::Model& model, const RunReport& report, const std::string& directory);

/// Writes that page to DIR/report.html.
void write_run_report(const codegen::Model& model, const RunReport& report, const std::string& directory);

}  // namespace nlo::trainer
