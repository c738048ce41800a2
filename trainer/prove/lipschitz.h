// SPDX-License-Identifier: MIT
// Bounds how much the inverse map T* of a model can amplify an error of z, or of the y that it reads. The upper bound
// is proven from the weights; the lower bound is the largest slope found at samples. Norms are spectral, in the units
// of the states. The local Lipschitz constant holds over the domain that in_domain() checks: the box of latent states
// and outputs in training. It is proven like the global constant and never larger. It is often several times smaller,
// because a network may be steeper outside of the box, and one layer may be steep where the next layer is not.
//
// The method is branch and bound. It halves the open box with the largest bound of |J| (jacobian_enclosure.h), until no
// bound exceeds the steepest slope found by more than `gap`, or the boxes are used up. The bounds hold in any case.
// Independent code also searches for steep slopes: a bound below a found slope is a defect.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "codegen/model/model.h"

namespace nlo::trainer {

/// |x_hat(z, y) - x_hat(z', y')| <= latent |z - z'| + output |y - y'|.
struct LipschitzConstants {
  double latent = 0.0;
  double output = 0.0;  ///< 0 if no feature reads y
};

/// Returns constants that hold for all z and y. Slopes of the activation are in [c - r, c + r] (tanh and relu: 1/2 +-
/// 1/2), so a Jacobian is W_L (c I + r S) W_(L-1) ... W_1 with unknown |S| <= 1. This product is expanded, and the norm
/// of each unbroken product of layers bounds it (Combettes and Pesquet 2020). The result is never above the product of
/// the layers' norms, and exact for one layer. It includes features, normalisation, scales and the linear path.
LipschitzConstants lipschitz_upper(const codegen::Model& model);

/// Returns the largest norm of the Jacobian over the columns of z (n_z x B) and readings y (n_r x B), by forward
/// differentiation. No constant can be smaller.
LipschitzConstants lipschitz_sampled(const codegen::Model& model, const Eigen::MatrixXd& z, const Eigen::MatrixXd& y);

/// Returns d x_hat / d [z; y] at one point, n_x x (n_z + n_r).
Eigen::MatrixXd inverse_map_jacobian(const codegen::Model& model, const Eigen::VectorXd& z, const Eigen::VectorXd& y);

/// Returns the largest singular value.
double spectral_norm(const Eigen::MatrixXd& matrix);

struct LocalLipschitzOptions {
  std::int64_t boxes = 0;       ///< largest number of boxes to examine; 0: as many as multiply_adds allow
  double gap = 0.01;            ///< the search ends once bound / found - 1 is below this
  Eigen::MatrixXd points = {};  ///< columns [z; y]: further start points in the box for the search for steep
                                ///< slopes

  /// Takes about two seconds of one core. It counts operations instead of using the clock, so that a result can be
  /// reproduced.
  static constexpr double kMultiplyAdds = 5e9;
  double multiply_adds = kMultiplyAdds;
};

struct LocalLipschitz {
  double bound = 0.0;        ///< no slope in the box is larger
  double found = 0.0;        ///< the steepest slope found in the box
  Eigen::VectorXd steepest;  ///< [z; y] of this slope
  std::int64_t boxes = 0;    ///< number examined
};

/// Bounds the slopes of T* in z, or with `of_output` in the readings y, over [latent_min, latent_max] x [reading_min,
/// reading_max]. For angle outputs the latent box is relative to S y, as in in_domain(). Throws codegen::Error if a
/// slope above the bound is found, which is a defect of this program.
LocalLipschitz local_lipschitz(const codegen::Model& model, bool of_output = false,
                               const LocalLipschitzOptions& options = {});

/// Searches for steep slopes by gradient ascent from `starts` random points of the box and from the steepest of
/// `points`, then draws around the end of each. Slopes are computed by inverse_map_jacobian().
LocalLipschitz steepest_slope(const codegen::Model& model, bool of_output, int starts = 32,
                              const Eigen::MatrixXd& points = {});

}  // namespace nlo::trainer
