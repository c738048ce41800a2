// SPDX-License-Identifier: MIT
// A Van der Pol test set of the protocol, simulated here so that these tests depend on no other part.
#pragma once

#include <cmath>
#include <random>
#include <string>

#include "trainer/data/dataset.h"

namespace nlo::trainer::test {

inline Eigen::MatrixXd van_der_pol(const Eigen::MatrixXd& x) {
  Eigen::MatrixXd dx(2, x.cols());
  dx.row(0) = x.row(1);
  dx.row(1) = (1.0 - x.row(0).array().square()) * x.row(1).array() - x.row(0).array();
  return dx;
}

/// Returns runs from initial states that are uniform over [-half_width, half_width]^2, by RK4 at 0.02 s.
inline Dataset van_der_pol_set(int trajectories, double horizon_s, unsigned long long seed, double half_width = 1.0) {
  constexpr double kStep = 0.02;
  const auto samples = static_cast<Eigen::Index>(std::lround(horizon_s / kStep)) + 1;
  Dataset set{{{"y", "", 0.0}}, {{"x1", "", 0.0}, {"x2", "", 0.0}}, kStep, true, {}};
  std::mt19937_64 engine(seed);
  const auto draw = [&] { return half_width * (2.0 * static_cast<double>(engine() >> 11) * 0x1p-53 - 1.0); };
  for (int i = 0; i < trajectories; ++i) {
    Trajectory run{"simulation " + std::to_string(i), Eigen::VectorXd(samples), Eigen::MatrixXd(1, samples),
                   Eigen::MatrixXd(2, samples), Eigen::VectorXd::Ones(samples)};
    Eigen::MatrixXd x(2, 1);
    x << draw(), draw();
    for (Eigen::Index k = 0; k < samples; ++k) {
      run.time_s[k] = kStep * static_cast<double>(k);
      run.states.col(k) = x;
      run.outputs(0, k) = x(0);
      const Eigen::MatrixXd k1 = van_der_pol(x), k2 = van_der_pol(x + 0.5 * kStep * k1),
                            k3 = van_der_pol(x + 0.5 * kStep * k2), k4 = van_der_pol(x + kStep * k3);
      x += kStep / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    set.trajectories.push_back(std::move(run));
  }
  return set;
}

}  // namespace nlo::trainer::test
