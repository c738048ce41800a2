// SPDX-License-Identifier: MIT
// Several filters of one plant with different initial states, weighted by how well each predicts the outputs. A bank
// helps if more than one state can explain the outputs, because one filter may settle at the wrong one.
//   log w_b += log N(innovation_b; 0, s_b),   x_hat = sum w_b x_b / sum w_b
// The mean of an angle is taken the shorter way round from the likeliest filter. Source: Alspach, Sorenson: Nonlinear
// Bayesian estimation using Gaussian sum approximations, IEEE Trans. AC 17(4), 1972.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "trainer/judge/filters/sigma_point_filter.h"

namespace nlo::trainer {

class FilterBank final : public LaneFilter {
 public:
  /// `starts`: n_x x K, initial states of the K filters. Every filter starts with the covariance P0 of `knowledge`.
  FilterBank(const LanePlant& plant, PointSet points, const FilterKnowledge& knowledge, const Eigen::MatrixXd& starts,
             const std::vector<FilterTuning>& tunings, Eigen::Index lanes);

  Eigen::MatrixXd step(const LaneRuns& runs, Eigen::Index k) override;
  int restarts() const override { return bank_.restarts(); }

  /// Returns w of each filter and lane after the last step, K x L.
  const Eigen::ArrayXXd& weights() const { return weights_; }

 private:
  Eigen::Index members_, lanes_;
  Eigen::VectorXd state_wraps_;
  SigmaPointFilter bank_;  ///< K blocks of L lanes
  LaneRuns samples_;       ///< samples of the runs, repeated K times
  Eigen::ArrayXXd log_weight_, weights_;
};

}  // namespace nlo::trainer
