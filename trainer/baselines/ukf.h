// SPDX-License-Identifier: MIT
// Unscented Kalman filter: the EKF's rival where the plant bends within the filter's own uncertainty.
#pragma once

#include <functional>

#include "trainer/baselines/filter.h"
#include "trainer/evaluation/evaluate.h"

namespace nlo::trainer {

/// Discrete UKF between samples on the symmetric set of 2 n_x + 1 points
///   X_0 = x,  X_i = x +- sqrt(n_x + kappa) [S]_i,  S S' = P        w_0 = kappa / (n_x + kappa), else 1 / (2 (n_x + kappa))
///   x- = sum w Phi(X),  P- = cov(Phi(X)) + Q                       Phi: RK4 steps of f over the sample period
///   K = cov(X, h(X)) (cov(h(X)) + R)^-1,  x+ = x- + K (y - mean h(X)),  P+ = P- - K S_y K'      X drawn anew of P-
/// with kappa = max(0, 3 - n_x): no weight is negative, so no covariance is; from three states on this is the cubature
/// filter. S is P's Cholesky factor, or where P is only semidefinite its symmetric square root. The innovation of an
/// angle is the short way round. Julier, Uhlmann: Unscented filtering and nonlinear estimation, Proc. IEEE 92(3), 2004.
EstimatorFactory ukf_estimator(std::function<FilterPlant()> make_plant, const FilterConfig& config);

}  // namespace nlo::trainer
