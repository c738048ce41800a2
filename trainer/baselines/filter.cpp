// SPDX-License-Identifier: MIT
#include "trainer/baselines/filter.h"

#include <algorithm>
#include <cmath>

#include "codegen/reference/rk4.h"
#include "trainer/data/angle.h"

namespace nlo::trainer {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd advance(const FilterPlant& plant, const MatrixXd& x, double h, const VectorXd& u0, const VectorXd& u1) {
  const auto f = [&](const MatrixXd& at, const VectorXd& u) {
    return plant.driven && u.size() > 0 ? plant.driven(at, u) : plant.f(at);
  };
  // A share below 1e-9 of a step is the rounding of time stamps.
  const double steps = std::max(1.0, std::ceil(h / plant.longest_step_s - 1e-9));
  MatrixXd next = x;
  for (double i = 0.0; i < steps; i += 1.0)
    next = codegen::rk4_step(next, h / steps, [&](double c, const MatrixXd& at) {
      const double share = (i + c) / steps;
      return f(at, share == 0.0 ? u0 : share == 1.0 ? u1 : VectorXd((1.0 - share) * u0 + share * u1));
    });
  return next;
}

MatrixXd output_at(const FilterPlant& plant, const MatrixXd& x, const VectorXd& u) {
  return plant.driven_output && u.size() > 0 ? plant.driven_output(x, u) : plant.h(x);
}

void wrap_outputs(const FilterPlant& plant, MatrixXd& difference) {
  for (Index j = 0; j < plant.output_wraps.size(); ++j)
    if (const double wrap = plant.output_wraps[j]; wrap > 0.0)
      difference.row(j) = difference.row(j).unaryExpr([wrap](double d) { return wrap_difference(d, wrap); });
}

MatrixXd process_covariance(const FilterConfig& config, double h) {
  const Index nx = config.initial_state.size();
  VectorXd variance = VectorXd::Constant(nx, config.process_variance);
  if (config.process_noise.size() > 0) variance += h * config.process_noise.cwiseAbs2();
  return variance.asDiagonal();
}

MatrixXd output_covariance(const FilterConfig& config, Index ny) {
  VectorXd variance = config.output_variance.cwiseMax(config.least_output_variance);
  if (variance.size() == 1) variance = VectorXd::Constant(ny, variance[0]);
  return variance.asDiagonal();
}

void restart_if_lost(const FilterConfig& config, VectorXd& x, MatrixXd& p) {
  constexpr double kEscape = 1e9;
  const VectorXd limits = config.farthest.size() > 0 ? config.farthest : VectorXd::Constant(x.size(), kEscape);
  if ((x.array().abs() <= limits.array()).all() && p.allFinite()) return;
  x = config.initial_state;
  p = config.initial_covariance;
}

HeldInputs inputs_of_step(const FilterConfig& config, const MatrixXd& inputs, Index k) {
  if (inputs.cols() == 0) return {};
  return {inputs.col(config.held_inputs || k == 0 ? k : k - 1), inputs.col(k)};
}

}  // namespace nlo::trainer
