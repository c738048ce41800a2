// SPDX-License-Identifier: MIT
// High-gain observer for one output, on lanes, stepped at the samples:
//   x- = Phi(x),   x = x- + O(x-)^-1 g (y - h(x-)),   O = d(y, y', ..., y^(n-1))/dx
// The derivatives of y along the plant are chains of integrators. For these, g is the gain of the fading-memory filter,
// with all poles at beta = exp(-theta h). Therefore theta is not limited by the sample period, unlike with gains k_i
// theta^i that are held between samples. n = 1: 1 - beta; n = 2: 1 - beta^2, (1 - beta)^2 / h; n = 3: 1 - beta^3, 3/2
// (1 - beta)^2 (1 + beta) / h, (1 - beta)^3 / h^2 (Zarchan, Musoff: Fundamentals of Kalman filtering, chapter on fading
// memory). Derivatives of y are central differences over one sample period in each direction.
#pragma once

#include <string>

#include "trainer/judge/filters/sigma_point_filter.h"

namespace nlo::trainer {

/// Returns the reason why a plant cannot have this filter; empty: it can.
std::string no_high_gain(Eigen::Index nx, Eigen::Index ny, Eigen::Index nu);

class HighGainObserver final : public LaneFilter {
 public:
  /// theta = sqrt(tuning.process) / (20 h). The other values of a tuning are not used.
  HighGainObserver(const LanePlant& plant, const FilterKnowledge& knowledge, const std::vector<FilterTuning>& tunings,
                   Eigen::Index lanes, double sample_period_s);

  Eigen::MatrixXd step(const LaneRuns& runs, Eigen::Index k) override;
  int restarts() const override { return restarts_; }

 private:
  LanePlant plant_;
  Eigen::MatrixXd x_, initial_state_, gains_;  ///< n_x x L each
  Eigen::ArrayXd limits_;                      ///< n_x
  Eigen::VectorXd step_;                       ///< n_x, steps of differences in x
  int restarts_ = 0;
};

}  // namespace nlo::trainer
