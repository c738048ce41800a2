// SPDX-License-Identifier: MIT
// Names of estimators in options and JSON keys, and words for people.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace nlo::trainer {

struct EstimatorWords {
  std::string_view name;     ///< "joint_ekf"
  std::string_view title;    ///< "joint EKF"
  std::string_view meaning;  ///< description
  bool knows_plant = true;   ///< and the noise
};

/// Names of the estimators that need no equations.
std::vector<std::string> simple_names();

/// Null: an observer, or a name that says it all.
const EstimatorWords* estimator_words(std::string_view name);

}  // namespace nlo::trainer
