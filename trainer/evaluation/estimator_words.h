// SPDX-License-Identifier: MIT
// What estimators are called: the names of options and of JSON keys, and the words for people.
#pragma once

#include <string_view>

namespace nlo::trainer {

struct EstimatorWords {
  std::string_view name;     ///< "joint_ekf"
  std::string_view title;    ///< "joint EKF"
  std::string_view meaning;  ///< what it is
  bool knows_plant = true;   ///< and the noise
};

/// Null: an observer, or a name that says it all.
const EstimatorWords* estimator_words(std::string_view name);

}  // namespace nlo::trainer
