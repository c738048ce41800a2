// SPDX-License-Identifier: MIT
// Q, R and P0 of a filter by what they make of logs whose truth is known.
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <functional>
#include <vector>

namespace nlo::trainer {

/// Coordinate search in decades: for steps of 1, 1/2 and 1/4 decade (`finer`: without the first) every coordinate is
/// tried one step up and down, until a sweep over all of them brings less than a per mille.
///   x      log10 of what is tuned
///   cost   of several points at once, one for each; NaN is never taken
/// Gives the best x and its cost. At most `most_sweeps` sweeps per step.
struct Tuned {
  Eigen::VectorXd x;
  double cost = 0.0;
  int evaluations = 0;
};
using CostsOf = std::function<std::vector<double>(const std::vector<Eigen::VectorXd>& points)>;
Tuned coordinate_search(const Eigen::VectorXd& start, const CostsOf& costs, bool finer = false,
                        const std::atomic<bool>* stop = nullptr, int most_sweeps = 4);

}  // namespace nlo::trainer
