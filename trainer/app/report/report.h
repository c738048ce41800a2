// SPDX-License-Identifier: MIT
// report.html: the result of a run as one self-contained page (inline style and SVG, no scripts). Every section is
// optional.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/app/report/run_results.h"
#include "trainer/data/log_dataset.h"
#include "trainer/judge/evaluation/evaluate.h"
#include "trainer/judge/evaluation/evaluate_logs.h"
#include "trainer/judge/evaluation/evaluation_study.h"

namespace nlo::trainer {

struct ReportData {
  std::string title;    ///< the model's name
  std::string warning;  ///< reason not to trust this model (training diverged or did not improve its start); shown
                        ///< first; empty: none
  /// Facts for reproduction. A value with several lines is shown whole.
  std::vector<std::pair<std::string, std::string>> facts;
  std::optional<TrainingCurves> training;
  std::vector<StudyRow> rows;  ///< one per noise
  std::optional<LogEvaluation> logs;
  std::optional<LogReport> log_clock;
  std::optional<ControlLoopResult> control_loop;
  std::vector<Channel> inputs = {};              ///< inputs of the model
  std::vector<std::string> derived_states = {};  ///< states of the logs whose truth is the slope of another column
};

/// Returns facts about the model and the run in `directory`: its metrics.csv, and its control_loop.json if that is not
/// older than its model.json. Throws codegen::Error if one of them exists and is damaged.
ReportData report_of(const codegen::Model& model, const std::string& directory);

/// Returns the page. Without a working gnuplot it has notes in place of the plots.
std::string render_report(const ReportData& data, const std::string& gnuplot = "gnuplot");

/// Renders and replaces `path` atomically.
void write_report(const ReportData& data, const std::string& path);

}  // namespace nlo::trainer
