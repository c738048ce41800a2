// SPDX-License-Identifier: MIT
// An exam is a published benchmark. Its table has rows for our observers, for filters tuned with care, for a simple
// estimator and for published results, each with its error and the cost of a sample.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace nlo::trainer::reproduction {

struct ExamRow {
  std::string name;
  std::vector<double> values = {};       ///< our errors, one for each training seed; a single one if nothing is random
  std::optional<double> published = {};  ///< error that others have published for their own test
  std::optional<double> multiply_adds = {};
};

/// Returns a row with a published result.
ExamRow published(const std::string& name, double figure, std::optional<double> multiply_adds = {});

struct ExamTable {
  std::string title, figure;  ///< "MSE [dB]"
  std::vector<ExamRow> rows;
};

std::string exam_text(const ExamTable& exam);
std::string exam_html(const ExamTable& exam);

/// Returns a table as numbers_csv() (numbers_csv.h) does: row is the row's name, column the figure and "multiply-adds".
std::string exams_csv(const std::vector<ExamTable>& exams);

}  // namespace nlo::trainer::reproduction
