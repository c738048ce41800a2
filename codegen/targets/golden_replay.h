// SPDX-License-Identifier: MIT
// Golden inputs and outputs of an exported header, to replay on any target: the results of a board are compared with
// the model's equations in double.
#pragma once

#include <string>

#include "codegen/targets/prepared_export.h"

namespace nlo::codegen {

/// Inputs, expected outputs, and tolerances of an export for each row of z, x_hat and sigma.
struct GoldenReplay {
  ReplayRun run;
  Eigen::VectorXd z_tolerance, x_hat_tolerance, sigma_tolerance = {};
};
GoldenReplay golden_replay(const PreparedExport& prepared);

/// Returns a header with `options.samples` measurements (smooth, with missing and out-of-range ones, some irregular
/// steps, angles that turn), the expected latent states, estimates and statuses, and tolerances, which are measured on
/// the machine that exports. Throws Error if the model is not valid.
std::string replay(const PreparedExport& prepared);

/// Returns the header of replay() in C99, for the files of target c99. Throws Error if C99 does not support the model.
std::string replay_c99(const PreparedExport& prepared);

}  // namespace nlo::codegen
