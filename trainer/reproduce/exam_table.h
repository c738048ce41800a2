// SPDX-License-Identifier: MIT
// An exam is a published benchmark. Its table has rows for our observers, for filters that were tuned for it, for a
// simple estimator and for published results. Each row has an error and the cost of one sample in multiply-adds.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace nlo::trainer::reproduction {

struct ExamRow {
  std::string name;
  /// Our errors, one for each training seed. A deterministic estimator has a single error.
  std::vector<double> values = {};
  std::optional<double> published = {};  ///< published error, from the authors' own test
  std::optional<double> multiply_adds = {};
};

/// Returns a row with a published result.
ExamRow published(const std::string& name, double figure, std::optional<double> multiply_adds = {});

struct ExamTable {
  std::string title, figure;  ///< figure: quantity and unit, such as "MSE [dB]"
  std::vector<ExamRow> rows;
};

std::string exam_text(const ExamTable& exam);
std::string exam_html(const ExamTable& exam);

/// Returns a table in the format of NumbersCsv (numbers_csv.h): row is the row's name, column is the figure or
/// "multiply-adds".
std::string exams_csv(const std::vector<ExamTable>& exams);

}  // namespace nlo::trainer::reproduction
