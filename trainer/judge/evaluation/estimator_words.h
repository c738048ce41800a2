// SPDX-License-Identifier: MIT
// Names of estimators in options and JSON keys, and their titles and descriptions for readers.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace nlo::trainer {

struct EstimatorWords {
  std::string_view name;     ///< "joint_ekf"
  std::string_view title;    ///< "joint EKF"
  std::string_view meaning;  ///< description
  bool knows_plant = true;   ///< true: it knows the plant and the noise
};

/// Returns the names of the estimators that need no equations.
std::vector<std::string> simple_names();

/// Returns the words for a name; null for an observer, or a name that needs no words.
const EstimatorWords* estimator_words(std::string_view name);

}  // namespace nlo::trainer
