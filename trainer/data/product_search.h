// SPDX-License-Identifier: MIT
// Which products of channels say more of the states than the channels do, judged on logs that are left out. A ridge
// regression reads each channel and two exponential averages of it; with a product and its averages beside them, its
// error on each log that it was not fitted on must fall. Products are taken one after another, the best first.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "trainer/data/dataset.h"

namespace nlo::trainer {

struct FoundProduct {
  std::string name, expression;  ///< "yaw_rate_wheel_speed", "yaw_rate * wheel_speed": an output that is computed
  double gain = 0.0;  ///< share by which the error on logs that are left out falls, typical over states and logs
};

/// Fewer logs do not tell.
inline constexpr std::size_t kFewestProductLogs = 3;

/// Products of two measured outputs or of one and an input; of none that wraps. None from fewer than
/// kFewestProductLogs, or where a product does not take 5 % of the error away and on most logs.
std::vector<FoundProduct> find_products(const Dataset& training);

}  // namespace nlo::trainer
