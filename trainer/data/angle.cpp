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
  // Whole turns are counted, not added up as angles, so that thousands of jumps at +-pi leave no rounding error.
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

Eigen::MatrixXd angles_encoded(const Eigen::MatrixXd& values, const std::vector<codegen::Channel>& channels) {
  std::vector<Eigen::VectorXd> rows;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const Eigen::VectorXd row = values.row(static_cast<Eigen::Index>(i));
    if (channels[i].wrap > 0.0) {
      rows.push_back(sine_of(row, channels[i].wrap));
      rows.push_back(cosine_of(row, channels[i].wrap));
    } else {
      rows.push_back(row);
    }
  }
  Eigen::MatrixXd result(static_cast<Eigen::Index>(rows.size()), values.cols());
  for (std::size_t i = 0; i < rows.size(); ++i) result.row(static_cast<Eigen::Index>(i)) = rows[i].transpose();
  return result;
}

Eigen::MatrixXd angles_decoded(const Eigen::MatrixXd& rows, const std::vector<codegen::Channel>& channels) {
  Eigen::MatrixXd values(static_cast<Eigen::Index>(channels.size()), rows.cols());
  Eigen::Index next = 0;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const double wrap = channels[i].wrap;
    if (wrap > 0.0) {
      values.row(row) = angle_of(rows.row(next).transpose(), rows.row(next + 1).transpose(), wrap).transpose();
      next += 2;
    } else {
      values.row(row) = rows.row(next++);
    }
  }
  return values;
}

}  // namespace nlo::trainer
