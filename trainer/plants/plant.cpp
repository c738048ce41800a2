// SPDX-License-Identifier: MIT
#include "trainer/plants/plant.h"

namespace nlo::trainer {

Eigen::MatrixXd Plant::driven_derivative(const Eigen::MatrixXd& x, const Eigen::MatrixXd& u) const {
  Eigen::MatrixXd dx = derivative(x);
  for (Eigen::Index j = 0; j < u.rows(); ++j) dx += input_field(x, j) * u.row(j).asDiagonal();
  return dx;
}

}  // namespace nlo::trainer
