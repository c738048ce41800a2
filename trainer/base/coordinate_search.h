// SPDX-License-Identifier: MIT
// Search along coordinates, for a few positive numbers whose order of magnitude is unknown, such as the Q, R and P0 of
// a filter.
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

/// Returns the costs of several points, one for each. A point with cost NaN is never chosen.
using CostsOf = std::function<std::vector<double>(const std::vector<Eigen::VectorXd>& points)>;

/// Tries each coordinate one step up and one step down and moves to the lower cost. Stops when a sweep over all
/// coordinates lowers the cost by less than a per mille. Steps are 1, then 1/2, then 1/4 decade.
///   start        log10 of the initial numbers
///   finer        leaves out the steps of a whole decade
///   stop         when it turns true, the search returns the best point so far
///   most_sweeps  largest number of sweeps per step
Tuned coordinate_search(const Eigen::VectorXd& start, const CostsOf& costs, bool finer = false,
                        const std::atomic<bool>* stop = nullptr, int most_sweeps = 4);

}  // namespace nlo::trainer
