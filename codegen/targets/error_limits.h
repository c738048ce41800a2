// SPDX-License-Identifier: MIT
// The error of an export for people: a table, and the limits that a user sets on it.
#pragma once

#include <Eigen/Core>
#include <string>

#include "codegen/targets/prepared_export.h"

namespace nlo::codegen {

/// "0.01" (every state, each in its unit) or "x1=0.01,x2=0.2" (the others are free) as one number per state. Throws
/// Error that names the states there are.
Eigen::VectorXd error_limits(const std::string& text, const Model& model);

/// "11,602 samples in its domain, of flights that training recorded".
std::string samples_text(const ExportError& error);

/// A line per state: the largest error in the domain, the 99.9 % quantile, rms, and the largest outside.
std::string error_table(const PreparedExport& prepared);

/// Empty when every maximum in the domain is within its limit (n_x; infinite: free); else the state that exceeds it,
/// by how much, and the remedy.
std::string beyond_limits(const PreparedExport& prepared, const Eigen::VectorXd& limits);

}  // namespace nlo::codegen
