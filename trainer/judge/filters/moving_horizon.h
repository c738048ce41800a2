// SPDX-License-Identifier: MIT
// Moving-horizon estimation on lanes: one Gauss-Newton step per sample over the last samples.
//   min over x_a of |S^-1 (x_a - x_bar)|^2 + sum_i rho((y_i - h(Phi^(i-a) x_a)) / sigma),   a = k - window + 1
// rho is quadratic up to the gate of the tuning and linear beyond (Huber), so that the effect of an outlier is limited.
// The arrival cost (x_bar, S) is the prediction for sample a by an EKF that runs one window behind. The step starts
// from the last solution, advanced by the plant. One step per sample is the real-time iteration of Diehl, Bock,
// Schloeder (2005). Within the window the plant has no process noise.
#pragma once

#include "trainer/judge/filters/sigma_point_filter.h"

namespace nlo::trainer {

class MovingHorizonFilter final : public LaneFilter {
 public:
  MovingHorizonFilter(const LanePlant& plant, const FilterKnowledge& knowledge,
                      const std::vector<FilterTuning>& tunings, Eigen::Index lanes, Eigen::Index window);

  Eigen::MatrixXd step(const LaneRuns& runs, Eigen::Index k) override;
  int restarts() const override { return arrival_.restarts() + restarts_; }

 private:
  LanePlant plant_;
  Eigen::Index nx_, lanes_, window_, start_ = 0;
  SigmaPointFilter arrival_;
  Eigen::MatrixXd x_;      ///< x_a, n_x x L
  Eigen::ArrayXd limits_;  ///< n_x
  std::vector<Eigen::ArrayXd> output_variance_;
  Eigen::ArrayXd gate_;  ///< L, limit of the quadratic part; infinite: no gate
  int restarts_ = 0;
};

}  // namespace nlo::trainer
