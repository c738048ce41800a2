// SPDX-License-Identifier: MIT
// Runs and plants for tests of filters on lanes.
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "trainer/judge/filters/sigma_point_filter.h"

namespace nlo::trainer::test {

/// Returns the plant dx/dt = -rate x, y = x.
inline LanePlant decay(double rate) {
  LanePlant plant;
  plant.nx = plant.ny = 1;
  plant.f = [rate](const Eigen::MatrixXd& x, const Eigen::MatrixXd&) { return Eigen::MatrixXd(-rate * x); };
  plant.h = [](const Eigen::MatrixXd& x, const Eigen::MatrixXd&) { return x; };
  plant.output_wraps = Eigen::VectorXd::Zero(1);
  return plant;
}

inline FilterKnowledge scalar_knowledge(double initial, double process, double output) {
  return {Eigen::VectorXd::Zero(1), Eigen::MatrixXd::Constant(1, 1, initial * initial),
          Eigen::VectorXd::Constant(1, process), Eigen::VectorXd::Constant(1, output)};
}

/// RK4 approximation of exp(-rate h).
inline double rk4_decay(double rate, double h) {
  const double a = rate * h;
  return 1.0 - a + a * a / 2.0 - a * a * a / 6.0 + a * a * a * a / 24.0;
}

inline LaneRuns runs_of(const Eigen::MatrixXd& outputs, double h) {
  const double last_s = h * static_cast<double>(outputs.cols() - 1);
  return one_run(outputs, {}, Eigen::VectorXd::LinSpaced(outputs.cols(), 0.0, last_s), false);
}

/// Returns the estimates of one lane, n_x x N.
inline Eigen::MatrixXd estimates_of(LaneFilter& filter, const LaneRuns& runs) {
  return filtered(filter, runs).x_hat;
}

/// Standard normal numbers, the same in each execution of the test.
inline Eigen::MatrixXd normals(Eigen::Index rows, Eigen::Index cols, unsigned seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd values(rows, cols);
  for (double& value : values.reshaped()) value = normal(engine);
  return values;
}

}  // namespace nlo::trainer::test
