// SPDX-License-Identifier: MIT
// Writes numbers and curves as CSV: one heading row, and the shortest numbers that read back to the same value.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "trainer/reproduce/section.h"

namespace nlo::trainer::reproduction {

/// A CSV text with one line for each cell and each way to compute the error (`reading`: strict or paper_like):
///   table,row,column,reading,metric,paper,mean,deviation,relative_to_paper,seed_1,...,seed_n
/// Fields without a number are empty.
class NumbersCsv {
 public:
  /// `cell`: the fields from `table` to `metric`. Without `values` there is no line.
  void add(const std::vector<std::string>& cell, const std::optional<double>& paper, const std::vector<double>& values,
           const std::optional<double>& relative_to_paper);

  /// Returns the CSV text; empty if there are no lines.
  std::string text() const;

 private:
  std::string lines_;
  std::size_t seeds_ = 0;
};

/// Returns the CSV text of all tables, with the strict and the paper-like error of each cell.
std::string numbers_csv(const Section& section);

/// Returns a CSV text with named columns of equal length.
std::string columns_csv(const std::vector<std::pair<std::string, Eigen::VectorXd>>& columns);

}  // namespace nlo::trainer::reproduction
