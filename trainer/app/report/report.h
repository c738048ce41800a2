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
  std::string warning;  ///< why not to trust this model (training got nowhere, diverged); shown first; empty: none
  /// For reproduction; a value of several lines is shown whole.
  std::vector<std::pair<std::string, std::string>> facts;
  std::optional<TrainingCurves> training;
  std::vector<StudyRow> rows;  ///< one per noise
  std::optional<LogEvaluation> logs;
  std::optional<LogReport> log_clock;
  std::optional<ControlLoopResult> control_loop;
  std::vector<Channel> inputs = {};              ///< inputs of the model
  std::vector<std::string> derived_states = {};  ///< states of the logs whose truth is the slope of another column
};

/// Facts of the model, and of the run that lies in `directory`: its metrics.csv, and its control_loop.json when that is
/// not older than its model.json. Throws codegen::Error when one of them is there and damaged.
ReportData report_of(const codegen::Model& model, const std::string& directory);

/// The page. Without a working gnuplot it says so in place of the plots.
std::string render_report(const ReportData& data, const std::string& gnuplot = "gnuplot");

/// Renders and replaces `path` atomically.
void write_report(const ReportData& data, const std::string& path);

}  // namespace nlo::trainer
