// SPDX-License-Identifier: MIT
#include "trainer/data/angle.h"

#include <cmath>
#include <numbers>

namespace nlo::trainer {

double wrap_difference(double difference, double wrap) {
  const double rest = std::remainder(difference, wrap);  // exact, in [-wrap/2, wrap/2]
  return rest <= -0.5 * wrap ? rest + wrap : rest;
}

Eigen::VectorXd unwrap(const Eigen::VectorXd& angle, double wrap) {
  Eigen::VectorXd result = angle;
  // Whole turns are counted, not summed up as angles: thousands of flickers at +-pi leave no rounding behind.
  double turns = 0.0;
  for (Eigen::Index k = 1; k < angle.size(); ++k) {
    const double step = angle[k] - angle[k - 1];
    turns -= std::round((step - wrap_difference(step, wrap)) / wrap);
    result[k] = angle[k] + turns * wrap;
  }
  return result;
}

Eigen::VectorXd sine_of(const Eigen::VectorXd& angle, double wrap) {
  return (angle.array() * (2.0 * std::numbers::pi / wrap)).sin();
}

Eigen::VectorXd cosine_of(const Eigen::VectorXd& angle, double wrap) {
  return (angle.array() * (2.0 * std::numbers::pi / wrap)).cos();
}

Eigen::VectorXd angle_of(const Eigen::VectorXd& sine, const Eigen::VectorXd& cosine, double wrap) {
  const double per_radian = wrap / (2.0 * std::numbers::pi);
  return sine.binaryExpr(cosine, [per_radian](double s, double c) { return per_radian * std::atan2(s, c); });
}

}  // namespace nlo::trainer
