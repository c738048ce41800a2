// SPDX-License-Identifier: MIT
// Proposition 2 and the remark on the approximation error, as numbers. With D_k = k D, lambda = max Re of D's
// eigenvalues, |w| <= w_bar on the state's derivative, |F v| <= v_bar on the injected output, and the initial error
// e0 = |z(0) - T_k(x(0))|,
//
//   |z - T_k(x)| <= exp(k lambda t) e0 + (L_Tkx w_bar + v_bar) / |k lambda|
//   |x - x~|     <= k^n_z sqrt(n_x) L_T (exp(k lambda t) e0 + (L_Tx / k w_bar + v_bar) / |k lambda|)     (19)
//   |x - x_hat|  <= l (bound of |z - T_k(x)|) + eps
//
// The first line is the first half of the proof. The second line is (19), for x~ = T_k*(z). The third line is the
// remark, for the learned x_hat.
//
// (19) is loose or wrong in these points:
//  - L_T and L_Tx are constants for k = 1; the factors k^n_z and 1/k convert them to other k. The step
//    |dT_k/dx| <= L_Tx / k compares two upper bounds, not the derivatives: on the undamped oscillator it fails for
//    every k > 1. L_Tk <= k^n_z L_T is claimed for k large enough (theorem 4.1 of the paper's source); where it holds,
//    it is far too large. Both are checked for each k and reported.
//  - The factor sqrt(n_x) comes from extending T^-1 component by component. An extension without this factor exists
//    (Kirszbraun); for a linear T it is the pseudo-inverse.
//  - (19) uses the slowest rate for all modes, but the noise decays in each mode at the mode's own rate.
//  - L_Tx is finite only if D is fast enough for T to be differentiable: faster than the plant contracts.
// Therefore each report shows a sharper bound beside (19) that avoids these points. It uses L of T* for this k, and
// each mode at its own rate:
//   |e|^2 <= sum over modes of ((V_i + L_i w_bar) / |Re lambda_i|)^2,   V_i = sup |F_i v|, L_i = sup |dT_i/dx|
#pragma once

#include <Eigen/Core>

#include "trainer/prove/latent_system.h"

namespace nlo::trainer {

/// value(t) = gain exp(rate t) e0 + steady, where e0 is the initial error in z.
struct ErrorBound {
  double gain = 0.0;    ///< [state / z]
  double rate = 0.0;    ///< [1/s], negative
  double steady = 0.0;  ///< [state]

  double at(double t_s, double initial_latent_error) const;

  /// Returns the first time [s] from which on the bound is at most `level`, for an initial error in z. It is at least
  /// 0, and infinite if the bound settles above `level`.
  double transient_s(double initial_latent_error, double level) const;
};

/// The constants of Proposition 2 for k = 1.
struct Proposition2 {
  Eigen::Index nx = 0, nz = 0;  ///< n_z: all rows of D, including clocks
  double lambda_max = 0.0;      ///< largest real part of D's eigenvalues [1/s]
  double l_t = 0.0;             ///< |x1 - x2| <= L_T |T(x1) - T(x2)|
  double l_tx = 0.0;            ///< |dT/dx| <= L_Tx
};

/// Returns (19) as printed.
ErrorBound bound_19(const Proposition2& proposition, double k, double w_bar, double v_bar);

/// Returns sup |F v| for |v_j| <= v(j). It is at a corner of the box, and all corners are tried. For more than 16
/// outputs, returns the sum of the columns' norms.
double injected_bound(const Eigen::MatrixXd& injection, const Eigen::VectorXd& v);

/// Returns the bound for one mode.
double injected_bound(const LatentMode& mode, const Eigen::VectorXd& v);

/// Computes the largest |row of dT/dx| for each mode (for a pair: the spectral norm of its two rows), and raises the
/// entries of `largest` (empty at first) to it.
void widen_row_slopes(const std::vector<LatentMode>& modes, const Eigen::MatrixXd& dt_dx, Eigen::VectorXd& largest);

/// Returns the steady bound of |z - T(x)|, mode by mode.
///   v           n_y: sup of each output's deviation, from noise and hold
///   row_slopes  per mode, see widen_row_slopes(); not used if w_bar = 0
double steady_latent_error(const LatentSystem& system, const Eigen::VectorXd& v, double w_bar,
                           const Eigen::VectorXd& row_slopes);

}  // namespace nlo::trainer
