// SPDX-License-Identifier: MIT
// The Lipschitz constant of T* where it is used: over the box of latent states and outputs that training has filled,
// the domain that in_domain() checks. Proven like the global one of lipschitz.h, never above it, and often several
// times smaller: outside of the box, and where one layer is steep and the next one is not, a net may be steeper.
//
// By branch and bound: of the boxes that are left, the one with the largest bound of |J| (jacobian_enclosure.h) is
// halved, until no bound is above the steepest slope found by more than `gap`, or the boxes are used up. What the
// bounds then say holds in any case. Beside it a search for steep slopes, by other code: a bound below one is a defect.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "codegen/model/model.h"
#include "trainer/bounds/lipschitz.h"

namespace nlo::trainer {

struct LocalLipschitzOptions {
  std::int64_t boxes = 0;       ///< to look at, at most; 0: what kMultiplyAdds allow
  double gap = 0.01;            ///< relative; less is not asked for
  Eigen::MatrixXd points = {};  ///< [z; y], a column each: where the search for steep slopes looks too, in the box

  /// Some two seconds of one core. By counting rather than by the clock, so that a result can be had again.
  static constexpr double kMultiplyAdds = 5e9;
};

struct LocalLipschitz {
  double bound = 0.0;        ///< no slope in the box is larger
  double found = 0.0;        ///< the steepest slope found there
  Eigen::VectorXd steepest;  ///< [z; y] of that
  std::int64_t boxes = 0;    ///< that were looked at
};

/// Slopes of T* in z, or with `of_output` in the y that it reads, over [latent_min, latent_max] x [output_min,
/// output_max]. For angle outputs the latent box is relative to S y, as in_domain() has it.
/// Throws codegen::Error when a slope is found above the bound, which is a defect of this program.
LocalLipschitz local_lipschitz(const codegen::Model& model, bool of_output = false,
                               const LocalLipschitzOptions& options = {});

/// The search for steep slopes: gradient ascent from `starts` random points of the box and from the steepest of
/// `points`, then draws around where each ends; slopes by inverse_map_jacobian().
LocalLipschitz steepest_slope(const codegen::Model& model, bool of_output, int starts = 32,
                              const Eigen::MatrixXd& points = {});

}  // namespace nlo::trainer
