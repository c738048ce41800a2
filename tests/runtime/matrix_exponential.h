// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace nlo::testing {

/// e^A, by Eigen. Here because its templates take half a minute to compile.
Eigen::MatrixXd exponential(const Eigen::MatrixXd& a);

}  // namespace nlo::testing
