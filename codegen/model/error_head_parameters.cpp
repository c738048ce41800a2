// SPDX-License-Identifier: MIT
#include "codegen/model/error_head_parameters.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace nlo::codegen {

FoldedErrorHead fold(const ErrorHead& head) {
  constexpr double kLog2e = std::numbers::log2e;
  const Eigen::VectorXd factor = head.factor_68.array().log().matrix();
  return {.layer = {kLog2e * head.weights, kLog2e * (head.bias + factor)},
          .lowest = kLog2e * (head.log_min + factor),
          .highest = kLog2e * (head.log_max + factor),
          .bound_95 = head.factor_95.cwiseQuotient(head.factor_68)};
}

Eigen::MatrixXd error_features(const Eigen::MatrixXd& hidden) {
  Eigen::MatrixXd features(2 * hidden.rows(), hidden.cols());
  features << hidden, hidden.cwiseAbs2();
  return features;
}

Eigen::MatrixXd deviations(const ErrorHead& head, const Eigen::MatrixXd& hidden, const std::vector<bool>& known) {
  Eigen::MatrixXd log_sigma = (head.weights * error_features(hidden)).colwise() + head.bias;
  for (Eigen::Index k = 0; k < log_sigma.cols(); ++k)
    for (Eigen::Index i = 0; i < log_sigma.rows(); ++i) {
      double& value = log_sigma(i, k);
      if (!(value < head.log_max(i))) value = head.log_max(i);
      value = std::max(value, head.log_min(i));
    }
  Eigen::MatrixXd sigma = head.factor_68.asDiagonal() * log_sigma.array().exp().matrix();
  for (Eigen::Index k = 0; k < sigma.cols(); ++k)
    if (!known[static_cast<std::size_t>(k)]) sigma.col(k).setConstant(static_cast<double>(kUnknownSigma));
  return sigma;
}

}  // namespace nlo::codegen
