// SPDX-License-Identifier: MIT
// Extended and unscented Kalman filter in square-root form, on lanes, with a gate on the innovation.
//
// P = S S' is never formed. Both filters evaluate the plant at the points x and x +- d S_i (S_i the columns of S) and
// differ in d and in their weights:
//            d                     mean           spread W, S- S-' = W W' + Q
//   EKF      1e-4                  Phi(x)         (Phi(x + d S_i) - Phi(x - d S_i)) / 2d, which is J S_i
//   UKF      sqrt(n_x + kappa)     sum w Phi(X)   sqrt(w) (Phi(X) - mean)
// S- is the triangular factor of [W sqrt(Q)], by modified Gram and Schmidt. The outputs correct one after the other,
// each by Potter's update with phi = S' H' (UKF: S^-1 cov(x,
// y)) and the innovation's variance s = phi' phi + r (UKF: of h(X)):
//   x+ = x- + S phi (y - y_hat) / s,   S+ = S - S phi phi' / (s + sqrt(s (s - phi' phi)))
// kappa = max(0, 3 - n_x), so no weight is negative, and no covariance can be. For three or more states the UKF is the
// cubature filter. The innovation of an angle is taken the shorter way round. The UKF: Julier, Uhlmann: Unscented
// filtering and nonlinear estimation, Proc. IEEE 92(3), 2004; in square-root form: van der Merwe, Wan, ICASSP 2001.
// Potter's update: Bierman, Factorization methods for discrete sequential estimation, 1977, chapter II.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "trainer/judge/filters/lane_plant.h"

namespace nlo::trainer {

/// The root of a covariance for each lane: entry (i, j) of all lanes is one array.
class LaneMatrix {
 public:
  LaneMatrix(Eigen::Index rows, Eigen::Index cols, Eigen::Index lanes)
      : cols_(cols), entries_(static_cast<std::size_t>(rows * cols), Eigen::ArrayXd::Zero(lanes)) {}

  Eigen::ArrayXd& operator()(Eigen::Index i, Eigen::Index j) {
    return entries_[static_cast<std::size_t>(i * cols_ + j)];
  }
  const Eigen::ArrayXd& operator()(Eigen::Index i, Eigen::Index j) const {
    return entries_[static_cast<std::size_t>(i * cols_ + j)];
  }
  Eigen::Index cols() const { return cols_; }

 private:
  Eigen::Index cols_;
  std::vector<Eigen::ArrayXd> entries_;
};

enum class PointSet { kExtended, kUnscented };

/// Noises and initial states that a filter assumes, the same for all lanes.
struct FilterKnowledge {
  Eigen::VectorXd initial_state;       ///< n_x
  Eigen::MatrixXd initial_covariance;  ///< P0, n_x x n_x
  Eigen::VectorXd process_deviation;   ///< n_x, square roots of Q's diagonal, per step
  Eigen::VectorXd output_deviation;    ///< n_y, square roots of R's diagonal
  Eigen::VectorXd farthest = {};       ///< n_x; an estimate with |x_i| beyond it is lost; empty: 1e9, the limit of
                                       ///< simulations
  Eigen::VectorXd process_noise = {};  ///< n_x, per sqrt(s); its square times the step is added to Q; empty: none

  Eigen::ArrayXd limits() const {
    if (farthest.size() > 0) return farthest.array();
    return Eigen::ArrayXd::Constant(initial_state.size(), 1e9);
  }
};

/// A tuning as factors on the filter's noises; 1: unchanged.
struct FilterTuning {
  double process = 1.0;  ///< factor on Q
  double output = 1.0;   ///< factor on R
  double initial = 1.0;  ///< factor on P0
  /// Further factors on Q and on P0, one for each state of the filter; empty: 1.
  std::vector<double> process_of = {}, initial_of = {};
  /// Gate [standard deviations]: a larger innovation is not used. After kMostRejected in a row the covariance is reset
  /// to P0, because the filter has lost the state.
  double gate = std::numeric_limits<double>::infinity();

  bool operator==(const FilterTuning&) const = default;
};
inline constexpr int kMostRejected = 20;

class SigmaPointFilter final : public LaneFilter {
 public:
  /// `tunings` divide the lanes evenly, in order: with 3 tunings and 12 lanes, the second has lanes 4 to 7.
  SigmaPointFilter(LanePlant plant, PointSet points, const FilterKnowledge& knowledge,
                   const std::vector<FilterTuning>& tunings, Eigen::Index lanes);

  Eigen::MatrixXd step(const LaneRuns& runs, Eigen::Index k) override;
  int restarts() const override { return restarts_; }
  Eigen::MatrixXd deviations() const override;

  /// The two halves of a step, for a caller that needs the intermediate values: predict() computes x and S for sample
  /// k, correct() applies its outputs.
  void predict(const LaneRuns& runs, Eigen::Index k);
  void correct(const LaneRuns& runs, Eigen::Index k);
  const Eigen::MatrixXd& state() const { return x_; }  ///< n_x x L
  const LaneMatrix& root() const { return root_; }

  /// Sets the initial state of each lane, n_x x L, which is also used after it is lost. Call it before the first step.
  void start_at(const Eigen::MatrixXd& states);
  /// Returns log p of the last sample's outputs given the earlier ones, L. An innovation beyond the gate counts as if
  /// it were at the gate.
  const Eigen::ArrayXd& log_likelihood() const { return log_likelihood_; }

 private:
  Eigen::MatrixXd points() const;
  void triangularise(LaneMatrix& w);
  void correct_one(Eigen::Index output, const Eigen::MatrixXd& y, const Eigen::MatrixXd& u);
  void restart_lost();

  LanePlant plant_;
  PointSet kind_;
  double spread_, centre_weight_, weight_;
  Eigen::Index nx_, lanes_;
  Eigen::MatrixXd x_, initial_state_;
  Eigen::ArrayXd limits_;                             ///< n_x
  Eigen::ArrayXd process_deviation_, process_noise_;  ///< n_x
  std::vector<Eigen::ArrayXd> process_factor_;        ///< n_x of L, square roots of the factors on Q
  LaneMatrix root_, initial_root_;
  std::vector<Eigen::ArrayXd> output_variance_;   ///< n_y
  Eigen::ArrayXd squared_gate_, log_likelihood_;  ///< L
  std::vector<Eigen::ArrayXi> rejected_;          ///< n_y of L: number in a row
  int restarts_ = 0;
};

}  // namespace nlo::trainer
