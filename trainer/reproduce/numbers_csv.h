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

/// One line per cell and reading:
///   table,row,column,reading,metric,paper,mean,deviation,relative_to_paper,seed_1,...,seed_n
/// An empty field where there is no number.
class NumbersCsv {
 public:
  /// `cell`: the fields from `table` to `metric`. Without `values` there is no line.
  void add(const std::vector<std::string>& cell, const std::optional<double>& paper, const std::vector<double>& values,
           const std::optional<double>& relative_to_paper);

  /// Empty without a line.
  std::string text() const;

 private:
  std::string lines_;
  std::size_t seeds_ = 0;
};

/// CSV of all tables, each cell in both readings.
std::string numbers_csv(const Section& section);

/// Named columns of equal length.
std::string columns_csv(const std::vector<std::pair<std::string, Eigen::VectorXd>>& columns);

}  // namespace nlo::trainer::reproduction
