// SPDX-License-Identifier: MIT
// Plain words on what an observer's errors are worth beside those of knowing nothing, a constant, and of a linear
// readout of its own features: the same for plants and for logs.
#pragma once

#include <string>
#include <vector>

namespace nlo::trainer {

/// A state whose error exceeds this share of another estimator's is not estimated better by the observer.
inline constexpr double kNoBetterThanConstant = 0.95;

/// Errors of one state in one window; NaN where there is none.
struct ComparedState {
  std::string name, unit;
  std::string window;  ///< in words: "settled (t >= 10 s)"
  double observer, constant, linear;
};

/// A note for each state that is not seen, and for each that the linear readout estimates as well. None is good news.
std::vector<std::string> comparison_notes(const std::vector<ComparedState>& states);

}  // namespace nlo::trainer
