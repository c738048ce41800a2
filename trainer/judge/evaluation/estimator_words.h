// SPDX-License-Identifier: MIT
// What estimators are called: the names of options and of JSON keys, and the words for people.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace nlo::trainer {

struct EstimatorWords {
  std::string_view name;     ///< "joint_ekf"
  std::string_view title;    ///< "joint EKF"
  std::string_view meaning;  ///< what it is
  bool knows_plant = true;   ///< and the noise
};

/// Those that know no plant: what a user has without equations.
std::vector<std::string> simple_names();

/// Null: an observer, or a name that says it all.
const EstimatorWords* estimator_words(std::string_view name);

}  // namespace nlo::trainer
