// SPDX-License-Identifier: MIT
// The error of an export for people: a table, and the limits that a user sets on it.
#pragma once

#include <Eigen/Core>
#include <string>

#include "codegen/model.h"
#include "codegen/replay_run.h"

namespace nlo::codegen {

/// "0.01" (every state, each in its unit) or "x1=0.01,x2=0.2" (the others are free) as one number per state. Throws
/// Error that names the states there are.
Eigen::VectorXd error_limits(const std::string& text, const Model& model);

/// One line per state: `  x2 [m/s]  max 5.9e-04  rms 2.2e-04`.
std::string error_table(const Model& model, const ExportOptions& options, const ExportError& error);

/// Empty when every maximum is within its limit (n_x; infinite: free); else which state is not, by how much, and what
/// would mend it.
std::string beyond_limits(const Model& model, const ExportOptions& options, const ExportError& error,
                          const Eigen::VectorXd& limits);

}  // namespace nlo::codegen
