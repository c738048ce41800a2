// SPDX-License-Identifier: MIT
// How much the inverse map T* of a model can amplify an error of z, or of the y it reads: from above, proven from the
// weights; from below, the largest slope found at samples. Spectral norms, in the states' units.
// The Lipschitz constant of T* where it is used: over the box of latent states and outputs that training has filled,
// the domain that in_domain() checks. Proven like the global one, never above it, and often several
// times smaller: outside of the box, and where one layer is steep and the next one is not, a net may be steeper.
//
// By branch and bound: of the boxes that are left, the one with the largest bound of |J| (jacobian_enclosure.h) is
// halved, until no bound is above the steepest slope found by more than `gap`, or the boxes are used up. What the
// bounds then say holds in any case. Beside it a search for steep slopes, by other code: a bound below one is a defect.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "codegen/model/model.h"

namespace nlo::trainer {

/// |x_hat(z, y) - x_hat(z', y')| <= latent |z - z'| + output |y - y'|.
struct LipschitzConstants {
  double latent = 0.0;
  double output = 0.0;  ///< 0 when no feature reads y
};

/// Holds for all z and y. Slopes of the activation lie in [c - r, c + r] (tanh and relu: 1/2 +- 1/2), so a Jacobian is
/// W_L (c I + r S) W_(L-1) ... W_1 with unknown |S| <= 1: multiplied out, and each unbroken run of layers bounded by
/// the norm of its product (Combettes and Pesquet 2020). Never above the product of the layers' norms; exact for one
/// layer. Features, normalisation, scales and the linear path are part of it.
LipschitzConstants lipschitz_upper(const codegen::Model& model);

/// The largest Jacobian norm over the columns of z (n_z x B) and readings y (n_r x B), by forward differentiation: no
/// constant can be smaller.
LipschitzConstants lipschitz_sampled(const codegen::Model& model, const Eigen::MatrixXd& z, const Eigen::MatrixXd& y);

/// d x_hat / d [z; y] at one point, n_x x (n_z + n_r).
Eigen::MatrixXd inverse_map_jacobian(const codegen::Model& model, const Eigen::VectorXd& z, const Eigen::VectorXd& y);

/// Largest singular value.
double spectral_norm(const Eigen::MatrixXd& matrix);

struct LocalLipschitzOptions {
  std::int64_t boxes = 0;       ///< to look at, at most; 0: as many as multiply_adds allow
  double gap = 0.01;            ///< relative; less is not asked for
  Eigen::MatrixXd points = {};  ///< [z; y], a column each: where the search for steep slopes looks too, in the box

  /// Some two seconds of one core. By counting rather than by the clock, so that a result can be had again.
  static constexpr double kMultiplyAdds = 5e9;
  double multiply_adds = kMultiplyAdds;
};

struct LocalLipschitz {
  double bound = 0.0;        ///< no slope in the box is larger
  double found = 0.0;        ///< the steepest slope found there
  Eigen::VectorXd steepest;  ///< [z; y] of that
  std::int64_t boxes = 0;    ///< number examined
};

/// Slopes of T* in z, or with `of_output` in the readings y, over [latent_min, latent_max] x [reading_min,
/// reading_max]. For angle outputs the latent box is relative to S y, as in_domain() has it.
/// Throws codegen::Error when a slope is found above the bound, which is a defect of this program.
LocalLipschitz local_lipschitz(const codegen::Model& model, bool of_output = false,
                               const LocalLipschitzOptions& options = {});

/// The search for steep slopes: gradient ascent from `starts` random points of the box and from the steepest of
/// `points`, then draws around where each ends; slopes by inverse_map_jacobian().
LocalLipschitz steepest_slope(const codegen::Model& model, bool of_output, int starts = 32,
                              const Eigen::MatrixXd& points = {});

}  // namespace nlo::trainer
