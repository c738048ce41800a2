// SPDX-License-Identifier: MIT
// Extended Kalman filter: what a user with an exact plant model would pick instead of a learned observer.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "trainer/baselines/filter.h"
#include "trainer/evaluation/coverage.h"
#include "trainer/evaluation/evaluate.h"

namespace nlo::trainer {

/// Guess at the centre of the box [low, high] (n_x each), P0 the variance of a uniform draw from it, R that of the
/// noise.
FilterConfig ekf_config(const Eigen::VectorXd& low, const Eigen::VectorXd& high, const NoiseConfig& noise);

/// Discrete EKF between samples,
///   x- = Phi(x+),  P- = J P+ J' + Q            Phi: RK4 steps of f over the sample period, J = dPhi/dx
///   K = P- H' (H P- H' + R)^-1,  x+ = x- + K (y - h(x-)),  P+ = (I - K H) P- (I - K H)' + K R K'   (Joseph form)
/// with Jacobians by central differences; the innovation y - h(x-) of an angle is the short way round. The first sample
/// corrects the initial guess at once. `make_plant` is called once per thread: plants need not be safe for two threads
/// at once.
EstimatorFactory ekf_estimator(std::function<FilterPlant()> make_plant, const FilterConfig& config);

/// The same with what P says of its errors: sqrt(P_ii) times 0.994 and 1.96, the intervals of a normal distribution.
IntervalEstimatorFactory ekf_intervals(std::function<FilterPlant()> make_plant, const FilterConfig& config);

}  // namespace nlo::trainer
