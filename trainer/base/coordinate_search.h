// SPDX-License-Identifier: MIT
// Search along coordinates, for a handful of positive numbers whose order of magnitude is unknown: the Q, R and P0 of a
// filter.
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <functional>
#include <vector>

namespace nlo::trainer {

struct Tuned {
  Eigen::VectorXd x;  ///< log10 of the numbers
  double cost = 0.0;
  int evaluations = 0;
};

/// The costs of several points, one for each; NaN is never taken.
using CostsOf = std::function<std::vector<double>(const std::vector<Eigen::VectorXd>& points)>;

/// Tries each coordinate one step up and one down and goes where the cost is lower, until a sweep over all coordinates
/// lowers it by less than a per mille. Steps are 1, then 1/2, then 1/4 decade.
///   start        log10 of the numbers to begin with
///   finer        without the steps of a whole decade
///   stop         when it turns true, the search ends with the best so far
///   most_sweeps  at most so many sweeps per step
Tuned coordinate_search(const Eigen::VectorXd& start, const CostsOf& costs, bool finer = false,
                        const std::atomic<bool>* stop = nullptr, int most_sweeps = 4);

}  // namespace nlo::trainer
