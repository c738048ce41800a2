// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace nlo::testing {

/// e^A, by Eigen, whose templates take long to compile: here once.
Eigen::MatrixXd exponential(const Eigen::MatrixXd& a);

}  // namespace nlo::testing
