// SPDX-License-Identifier: MIT
// Several filters of one plant that start apart, weighed by how well each foretells the outputs: for outputs that more
// than one state may explain, where one filter settles at the wrong one.
//   log w_b += log N(innovation_b; 0, s_b),   x_hat = sum w_b x_b / sum w_b
// An angle's mean is taken the short way round from the likeliest filter's.
// Source: Alspach, Sorenson: Nonlinear Bayesian estimation using Gaussian sum approximations, IEEE Trans.
// AC 17(4), 1972.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "trainer/judge/filters/sigma_point_filter.h"

namespace nlo::trainer {

class FilterBank final : public LaneFilter {
 public:
  /// `starts`: n_x x K, where the filters begin, each with the P0 of `knowledge` about its own start.
  FilterBank(const LanePlant& plant, PointSet points, const FilterKnowledge& knowledge, const Eigen::MatrixXd& starts,
             const std::vector<FilterTuning>& tunings, Eigen::Index lanes);

  Eigen::MatrixXd step(const LaneRuns& runs, Eigen::Index k) override;
  int restarts() const override { return bank_.restarts(); }

  /// w of each filter and lane after the last step, K x L.
  const Eigen::ArrayXXd& weights() const { return weights_; }

 private:
  Eigen::Index members_, lanes_;
  Eigen::VectorXd state_wraps_;
  SigmaPointFilter bank_;  ///< K blocks of L lanes
  LaneRuns samples_;       ///< samples of the runs, K times side by side
  Eigen::ArrayXXd log_weight_, weights_;
};

}  // namespace nlo::trainer
