// SPDX-License-Identifier: MIT
// An exam: a published benchmark. Rows for our observers, filters that a careful engineer would tune, a simple
// estimator, and published results, each with its figure and the cost of a sample.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace nlo::trainer::reproduction {

struct ExamRow {
  std::string name;
  std::vector<double> values = {};       ///< ours, one for each training seed; one where nothing is drawn
  std::optional<double> published = {};  ///< published by others for their own test
  std::optional<double> multiply_adds = {};
};

/// A row of others.
ExamRow published(const std::string& name, double figure, std::optional<double> multiply_adds = {});

struct ExamTable {
  std::string title, figure;  ///< "MSE [dB]"
  std::vector<ExamRow> rows;
};

std::string exam_text(const ExamTable& exam);
std::string exam_html(const ExamTable& exam);

/// As numbers_csv() (numbers_csv.h): row the row's name, column the figure and "multiply-adds".
std::string exams_csv(const std::vector<ExamTable>& exams);

}  // namespace nlo::trainer::reproduction
