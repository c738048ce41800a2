// SPDX-License-Identifier: MIT
// Successive halving (Jamieson and Talwalkar 2016): many trainings begin short; the best quarter is trained four times
// as long; and so on. Rungs take the same time each.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace nlo::trainer {

struct Rung {
  std::size_t candidates = 0;
  double seconds = 0.0;  ///< of the training of each
};

inline constexpr std::size_t kKeptPart = 4;  ///< one in so many goes on, two at least

/// Rungs of so many candidates that take `seconds` together with one more training as long as the last rung's: that of the
/// winner, for its model. `candidates` > 0, `seconds` > 0.
std::vector<Rung> halving_rungs(std::size_t candidates, double seconds);

/// As many candidates as get two seconds in the first rung, or three times what a training needs before its first step
/// where that is more, 4 to 64.
std::size_t candidates_for(double seconds, double setup_s);

/// Which of a rung go on: the `count` of least error, in that order; equal ones by their place. One without an error
/// (its training diverged) never does.
std::vector<std::size_t> best_of(const std::vector<std::optional<double>>& errors, std::size_t count);

}  // namespace nlo::trainer
