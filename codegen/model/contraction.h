// SPDX-License-Identifier: MIT
// Contraction of a gated latent system, proven from its weights:
// two runs on the same readings forget where they started,
//   max_i |z_i - z'_i| / d_i   falls to a share q of it, or less, with each sample a period apart.
//
// With s = (1 + tanh a_s) / 2 the Jacobian of z+ = z + s (target - z) has rows
//   (1 - s_i) e_i + s_i dtarget_i/dz + (target_i - z_i) ds_i/dz.
// |tanh'| <= 1, 0 < g < 1, |dg/da_g| <= 1/2, |z| <= 1, |target - z| <= 2 and ds/da_s = 2 s (1 - s) <= 2 s bound the
// size of row i in that norm by 1 - s_i (1 - c_i), where
//   c = M d / d,   M = 4 |W_s| + |W_c| (I + |W_g| / 2)
// of the weights of a_s, a_g and the candidate on z. Where every c_i < 1,
//   q = max_i 1 - s_i,min (1 - c_i),   s_i,min: the least over |z| <= 1 and readings within their ranges.
// By the equations in exact arithmetic: an export adds its rounding at each step,
// whose effect stays below 1 / (1 - q) of it.
#pragma once

#include <Eigen/Core>

namespace nlo::codegen {

struct Gated;
struct Model;

/// None where `metric` has no entry.
struct Contraction {
  Eigen::VectorXd metric;  ///< d, n_z, positive
  double rate = 0.0;       ///< -ln(q) / sample period [1/s]

  bool none() const { return metric.size() == 0; }
};

/// M, n_z x n_z.
Eigen::MatrixXd coupling(const Gated& gated, Eigen::Index units);

/// The rate that a metric proves for a gated model, by its weights and ranges; 0: none.
double proven_rate(const Model& model, const Gated& gated, const Eigen::VectorXd& metric);

/// By the better of two metrics: all ones, and M's dominant eigenvector, in which the largest c_i is least. None where
/// neither proves a rate.
Contraction find_contraction(const Model& model, const Gated& gated);

}  // namespace nlo::codegen
