// SPDX-License-Identifier: MIT
// A Kalman filter without a plant: position, velocity and acceleration of one measured quantity, whose acceleration is
// a random walk. The firmware of a drive may do this with an encoder.
#pragma once

#include <Eigen/Core>

namespace nlo::trainer {

/// Kalman filter of p''' = w with white w of intensity q; y = p + v, v of variance r. Over a step of h seconds
///   F = [1 h h^2/2; 0 1 h; 0 0 1],  Q = q [h^5/20 h^4/8 h^3/6; h^4/8 h^3/3 h^2/2; h^3/6 h^2/2 h]
/// exactly, for any h. The estimates depend only on q / r.
///   Bar-Shalom, Li, Kirubarajan: Estimation with applications to tracking and navigation, 2001, section 6.2.3.
struct ConstantAcceleration {
  double jerk_intensity = 1.0;   ///< q [unit^2/s^5]
  double output_variance = 1.0;  ///< r [unit^2]
  double wrap = 0.0;             ///< full turn of the quantity; 0: no angle

  /// Returns position, velocity and acceleration at each sample, 3 x N. The filter starts at the first measurement, at
  /// rest, with P0 = diag(r, v^2, (v / tau)^2). tau = (r / q)^(1/5) is the filter's own time, and v = 1000 sqrt(r) /
  /// tau, because velocity and acceleration are unknown.
  Eigen::MatrixXd estimate(const Eigen::VectorXd& time_s, const Eigen::VectorXd& measured) const;
};

}  // namespace nlo::trainer
