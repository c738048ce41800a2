// SPDX-License-Identifier: MIT
// Finds products of channels that improve a prediction of the states on logs that are left out. A ridge regression
// reads each channel and two exponential averages of it. A product and its averages must reduce its error on each log
// to which it was not fitted. Products are added one after another, the best first.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "trainer/data/dataset.h"

namespace nlo::trainer {

struct FoundProduct {
  std::string name, expression;  ///< "yaw_rate_wheel_speed", "yaw_rate * wheel_speed": name and expression of a
                                 ///< computed output
  double gain = 0.0;             ///< typical relative reduction of the error on left-out logs, over states and logs
};

/// Fewest logs for a decision.
inline constexpr std::size_t kFewestProductLogs = 3;

/// Considers products of two measured outputs, or of an output and an input, without channels that wrap. Returns none
/// for fewer than kFewestProductLogs logs, or if a product does not reduce the error by 5 % and on most logs.
std::vector<FoundProduct> find_products(const Dataset& training);

}  // namespace nlo::trainer
