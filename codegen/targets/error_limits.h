// SPDX-License-Identifier: MIT
// The error of an export for users: a table, and the limits that a user sets.
#pragma once

#include <Eigen/Core>
#include <string>

#include "codegen/targets/prepared_export.h"

namespace nlo::codegen {

/// Reads limits: "0.01" (for every state, in its unit) or "x1=0.01,x2=0.2" (the other states are not limited). Returns
/// one number per state. Throws Error that names the model's states.
Eigen::VectorXd error_limits(const std::string& text, const Model& model);

/// Describes the samples: "11,602 samples in its domain, from flights that training recorded".
std::string samples_text(const ExportError& error);

/// Returns a line per state: the largest error in the domain, the 99.9 % quantile, rms, and the largest outside.
std::string error_table(const PreparedExport& prepared);

/// Returns an empty text if the largest error of every state in the domain is within its limit (n_x; infinite: no
/// limit). Otherwise it names the state, its error and the remedy.
std::string beyond_limits(const PreparedExport& prepared, const Eigen::VectorXd& limits);

}  // namespace nlo::codegen
