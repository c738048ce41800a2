// SPDX-License-Identifier: MIT
// Golden inputs and answers for an exported header, to replay on any target: what a board computes is held against the
// model's equations in double.
#pragma once

#include <string>

#include "codegen/targets/prepared_export.h"

namespace nlo::codegen {

/// Inputs, the answers that must follow, and how far those of an export may be off, in each row of z, x_hat, sigma.
struct GoldenReplay {
  ReplayRun run;
  Eigen::VectorXd z_tolerance, x_hat_tolerance, sigma_tolerance = {};
};
GoldenReplay golden_replay(const PreparedExport& prepared);

/// A header with `options.samples` measurements (smooth, with missed and out-of-range ones, a stretch of irregular
/// steps, angles that turn), the latent states, estimates and statuses that must follow, and the tolerances, measured
/// by the machine that exports. Throws Error when the model is not valid.
std::string replay(const PreparedExport& prepared);

/// The same in C99, for what target c99 writes. Throws Error unless that is a KKL observer.
std::string replay_c99(const PreparedExport& prepared);

}  // namespace nlo::codegen
