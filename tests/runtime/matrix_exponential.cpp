// SPDX-License-Identifier: MIT
#include "tests/runtime/matrix_exponential.h"

#include <unsupported/Eigen/MatrixFunctions>

namespace nlo::testing {

Eigen::MatrixXd exponential(const Eigen::MatrixXd& a) {
  return a.exp();
}

}  // namespace nlo::testing
