// SPDX-License-Identifier: MIT
// Proves from its weights that a gated latent system contracts: the distance of two runs on the same readings,
//   max_i |z_i - z'_i| / d_i,   falls at least by the factor q in every sample period.
//
// With s = (1 + tanh a_s) / 2 the Jacobian of z+ = z + s (target - z) has rows
//   (1 - s_i) e_i + s_i dtarget_i/dz + (target_i - z_i) ds_i/dz.
// |tanh'| <= 1, 0 < g < 1, |dg/da_g| <= 1/2, |z| <= 1, |target - z| <= 2 and ds/da_s = 2 s (1 - s) <= 2 s bound the
// size of row i in that norm by 1 - s_i (1 - c_i), where
//   c = M d / d,   M = 4 |W_s| + |W_c| (I + |W_g| / 2)
// with the weights of a_s, a_g and the candidate on z. If every c_i < 1,
//   q = max_i 1 - s_i,min (1 - c_i),   s_i,min: the least over |z| <= 1 and readings within their ranges.
// This holds in exact arithmetic. An export adds a rounding error at each step, whose effect stays below 1 / (1 - q)
// times that error.
#pragma once

#include <Eigen/Core>

namespace nlo::codegen {

struct Gated;
struct Model;

/// A proof of contraction. If `metric` is empty, there is none.
struct Contraction {
  Eigen::VectorXd metric;  ///< d, n_z, positive
  double rate = 0.0;       ///< -ln(q) / sample period [1/s]

  bool none() const { return metric.size() == 0; }
};

/// Returns M, n_z x n_z.
Eigen::MatrixXd coupling(const Gated& gated, Eigen::Index units);

/// Returns the rate that a metric proves for a gated model from its weights and ranges; 0: none.
double proven_rate(const Model& model, const Gated& gated, const Eigen::VectorXd& metric);

/// Returns the better of two metrics: all ones, and the dominant eigenvector of M, which minimises the largest c_i.
/// Returns none if neither proves a rate.
Contraction find_contraction(const Model& model, const Gated& gated);

}  // namespace nlo::codegen
