// SPDX-License-Identifier: MIT
#include "trainer/judge/filters/constant_acceleration.h"

#include <cmath>

#include "trainer/data/angle.h"

namespace nlo::trainer {

Eigen::MatrixXd ConstantAcceleration::estimate(const Eigen::VectorXd& time_s, const Eigen::VectorXd& measured) const {
  constexpr double kUnknown = 1e3;
  const double q = jerk_intensity, r = output_variance;
  const double tau = std::pow(r / q, 0.2), velocity = kUnknown * std::sqrt(r) / tau;
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  Eigen::Matrix3d p = Eigen::Vector3d(r, velocity * velocity, std::pow(velocity / tau, 2)).asDiagonal();
  Eigen::MatrixXd estimates(3, measured.size());
  for (Eigen::Index k = 0; k < measured.size(); ++k) {
    if (k == 0) {
      x[0] = measured[0];
      estimates.col(0) = x;
      continue;
    }
    const double h = time_s[k] - time_s[k - 1], h2 = h * h, h3 = h2 * h;
    Eigen::Matrix3d f, noise;
    f << 1.0, h, 0.5 * h2, 0.0, 1.0, h, 0.0, 0.0, 1.0;
    noise << h2 * h3 / 20.0, h2 * h2 / 8.0, h3 / 6.0, h2 * h2 / 8.0, h3 / 3.0, h2 / 2.0, h3 / 6.0, h2 / 2.0, h;
    x = (f * x).eval();
    p = (f * p * f.transpose() + q * noise).eval();
    double innovation = measured[k] - x[0];
    if (wrap > 0.0) innovation = wrap_difference(innovation, wrap);
    const Eigen::Vector3d gain = p.col(0) / (p(0, 0) + r);
    x += gain * innovation;
    Eigen::Matrix3d kept = Eigen::Matrix3d::Identity();
    kept.col(0) -= gain;
    p = (kept * p * kept.transpose() + r * gain * gain.transpose()).eval();
    estimates.col(k) = x;
  }
  return estimates;
}

}  // namespace nlo::trainer
