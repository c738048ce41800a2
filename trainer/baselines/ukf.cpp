// SPDX-License-Identifier: MIT
#include "trainer/baselines/ukf.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "codegen/base/linear_algebra.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct SigmaPoints {
  SigmaPoints(const VectorXd& x, const MatrixXd& p)
      : weights(VectorXd::Constant(2 * x.size() + 1, 0.0)), points(x.rowwise().replicate(2 * x.size() + 1)) {
    const auto n = static_cast<double>(x.size());
    const double kappa = std::max(0.0, 3.0 - n);
    const MatrixXd spread = std::sqrt(n + kappa) * codegen::square_root(p);
    for (Index i = 0; i < x.size(); ++i) {
      points.col(1 + 2 * i) += spread.col(i);
      points.col(2 + 2 * i) -= spread.col(i);
    }
    weights.setConstant(0.5 / (n + kappa));
    weights[0] = kappa / (n + kappa);
  }

  VectorXd weights;
  MatrixXd points;
};

MatrixXd run_ukf(const FilterPlant& plant, const FilterConfig& config, const MatrixXd& outputs, const MatrixXd& inputs,
                 const VectorXd& time_s) {
  const Index nx = config.initial_state.size();
  const MatrixXd r = output_covariance(config, outputs.rows());
  VectorXd x = config.initial_state;
  MatrixXd p = config.initial_covariance, estimates(nx, outputs.cols());
  for (Index k = 0; k < outputs.cols(); ++k) {
    const HeldInputs u = inputs_of_step(config, inputs, k);
    if (k > 0) {
      const SigmaPoints sigma(x, p);
      const double h = time_s[k] - time_s[k - 1];
      MatrixXd next = advance(plant, sigma.points, h, u.from, u.to);
      x = next * sigma.weights;
      next.colwise() -= x;
      p = next * sigma.weights.asDiagonal() * next.transpose() + process_covariance(config, h);
    }
    const SigmaPoints sigma(x, p);
    const MatrixXd predicted = output_at(plant, sigma.points, u.to);
    // Angles: differences from the central point first, which are small, and their mean after.
    MatrixXd dy = predicted.colwise() - predicted.col(0);
    wrap_outputs(plant, dy);
    const VectorXd mean_difference = dy * sigma.weights;
    dy.colwise() -= mean_difference;
    const MatrixXd dx = sigma.points.colwise() - x;
    const MatrixXd s = dy * sigma.weights.asDiagonal() * dy.transpose() + r;
    const MatrixXd cross = dx * sigma.weights.asDiagonal() * dy.transpose();
    const MatrixXd gain = codegen::solve_symmetric(s, cross.transpose()).transpose();
    MatrixXd innovation = outputs.col(k) - predicted.col(0) - mean_difference;
    wrap_outputs(plant, innovation);
    x += gain * innovation;
    p -= gain * s * gain.transpose();
    p = (0.5 * (p + p.transpose())).eval();
    restart_if_lost(config, x, p);
    estimates.col(k) = x;
  }
  return estimates;
}

}  // namespace

EstimatorFactory ukf_estimator(std::function<FilterPlant()> make_plant, const FilterConfig& config) {
  return [make_plant = std::move(make_plant), config]() -> Estimator {
    return [plant = make_plant(), config](const MatrixXd& outputs, const MatrixXd& inputs, const VectorXd& time_s) {
      return run_ukf(plant, config, outputs, inputs, time_s);
    };
  };
}

}  // namespace nlo::trainer
