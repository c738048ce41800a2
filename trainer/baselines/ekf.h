// SPDX-License-Identifier: MIT
// Extended Kalman filter: what a user with an exact plant model would pick instead of a learned observer.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "trainer/evaluation/evaluate.h"

namespace nlo::trainer {

/// dx/dt = f(x) or, where inputs are known, driven(x, u), y = h(x); each maps a batch of x, one column per point, with
/// one u (n_u) for all.
struct EkfPlant {
  std::function<Eigen::MatrixXd(const Eigen::MatrixXd&x)> f, h;
  std::function<Eigen::MatrixXd(const Eigen::MatrixXd& x, const Eigen::VectorXd& u)> driven = {};  ///< null: autonomous
  Eigen::VectorXd output_wraps = {};  ///< full turns of outputs that are angles, else 0, n_y; empty: none is
};

/// Discrete EKF between samples,
///   x- = Phi(x+),  P- = J P+ J' + Q            Phi: one RK4 step of f, J = dPhi/dx
///   K = P- H' (H P- H' + R)^-1,  x+ = x- + K (y - h(x-)),  P+ = (I - K H) P- (I - K H)' + K R K'   (Joseph form)
/// with Jacobians by central differences; the innovation y - h(x-) of an angle is the short way round. The first sample
/// corrects the initial guess at once.
struct EkfConfig {
  Eigen::VectorXd initial_state;       ///< n_x
  Eigen::MatrixXd initial_covariance;  ///< P0, n_x x n_x
  double process_variance = 1e-6;      ///< Q = this times I, per step
  /// Diagonal of R, one for all outputs or n_y; at least 1e-4 each: a noise-free output is no reason to trust a
  /// linearisation.
  Eigen::VectorXd output_variance = Eigen::VectorXd::Zero(1);
  /// n_x, standard deviation per sqrt(s) of the plant's own noise: its square times the step is added to Q; empty: none.
  Eigen::VectorXd process_noise = {};
  bool held_inputs = false;  ///< the u of a sample has acted since the sample before; else a ramp from there
};

/// Guess at the centre of the box [low, high] (n_x each), P0 the variance of a uniform draw from it, R that of the
/// noise.
EkfConfig ekf_config(const Eigen::VectorXd& low, const Eigen::VectorXd& high, const NoiseConfig& noise);

/// `make_plant` is called once per thread: plants need not be safe for two threads at once.
EstimatorFactory ekf_estimator(std::function<EkfPlant()> make_plant, const EkfConfig& config);

}  // namespace nlo::trainer
