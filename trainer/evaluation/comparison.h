// SPDX-License-Identifier: MIT
// Plain words on what an observer's errors are worth beside those of knowing nothing, a constant, and of the best of
// the simple estimators: the same for plants and for logs.
#pragma once

#include <string>
#include <vector>

namespace nlo::trainer {

/// A state whose error exceeds this share of another estimator's is not estimated better by the observer.
inline constexpr double kNoBetterThanConstant = 0.95;

/// Errors of one state in one window; NaN where there is none.
struct ComparedState {
  std::string name, unit;
  std::string window;                 ///< in words: "settled (t >= 10 s)"
  double observer, constant, simple;  ///< simple: the best of the others, such as a linear readout
  std::string simple_name = "a ridge regression on the same features";
};

/// A note for each state that is not seen, and for each that something simple estimates as well. None is good news.
std::vector<std::string> comparison_notes(const std::vector<ComparedState>& states);

}  // namespace nlo::trainer
