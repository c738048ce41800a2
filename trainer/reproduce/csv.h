// SPDX-License-Identifier: MIT
// Numbers and curves as CSV: one heading row, shortest round-trip numbers.
#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "trainer/reproduce/section.h"

namespace nlo::trainer::reproduction {

/// One line per cell and reading:
///   table,row,column,reading,metric,paper,mean,deviation,relative_to_paper,seed_1,...,seed_n
/// An empty field where there is no number. Empty text without tables.
std::string numbers_csv(const Section& section);

/// Named columns of equal length.
std::string columns_csv(const std::vector<std::pair<std::string, Eigen::VectorXd>>& columns);

}  // namespace nlo::trainer::reproduction
