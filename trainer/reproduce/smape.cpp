// SPDX-License-Identifier: MIT
#include "trainer/reproduce/smape.h"

#include <cmath>

namespace nlo::trainer {
namespace {

/// Returns 200 error / size, or 0 if both are exactly 0.
double percentage(double error, double size) {
  return size == 0.0 ? 0.0 : 200.0 * error / size;
}

}  // namespace

double smape_of_components(const Eigen::MatrixXd& truth, const Eigen::MatrixXd& estimate) {
  double sum = 0.0;
  for (Eigen::Index k = 0; k < truth.cols(); ++k)
    for (Eigen::Index i = 0; i < truth.rows(); ++i)
      sum += percentage(std::abs(truth(i, k) - estimate(i, k)), std::abs(truth(i, k)) + std::abs(estimate(i, k)));
  return sum / static_cast<double>(truth.size());
}

double smape_of_norms(const Eigen::MatrixXd& truth, const Eigen::MatrixXd& estimate, const Eigen::VectorXd& time_s,
                      double from_s) {
  constexpr double kSlackS = 1e-6;  // 5 s in steps of 0.05 s may be computed as 4.99999 s
  double sum = 0.0;
  Eigen::Index samples = 0;
  for (Eigen::Index k = 0; k < truth.cols(); ++k) {
    if (time_s(k) < from_s - kSlackS) continue;
    sum += percentage((truth.col(k) - estimate.col(k)).norm(), truth.col(k).norm() + estimate.col(k).norm());
    ++samples;
  }
  return sum / static_cast<double>(samples);
}

}  // namespace nlo::trainer
