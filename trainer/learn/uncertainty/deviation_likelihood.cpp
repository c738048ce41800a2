// SPDX-License-Identifier: MIT
#include "trainer/learn/uncertainty/deviation_likelihood.h"

#include <cmath>
#include <limits>

#include "codegen/base/linear_algebra.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd log_deviations(const MatrixXd& features, const VectorXd& parameters) {
  const Index n = features.rows();
  return (features.transpose() * parameters.head(n)).array() + parameters(n);
}

/// Returns r^2 exp(-2 s), N.
VectorXd scaled_squares(const VectorXd& squares, const VectorXd& s) {
  return squares.array() * (-2.0 * s.array()).exp();
}

double cost_at(const VectorXd& s, const VectorXd& scaled, const VectorXd& weights, const VectorXd& parameters,
               double ridge) {
  return weights.dot(s + 0.5 * scaled) / weights.sum() +
         0.5 * ridge * parameters.head(parameters.size() - 1).squaredNorm();
}

}  // namespace

double deviation_cost(const MatrixXd& features, const VectorXd& squares, const VectorXd& weights,
                      const VectorXd& parameters, double ridge) {
  const VectorXd s = log_deviations(features, parameters);
  return cost_at(s, scaled_squares(squares, s), weights, parameters, ridge);
}

DeviationLikelihood deviation_likelihood(const MatrixXd& features, const VectorXd& squares, const VectorXd& weights,
                                         const VectorXd& parameters, double ridge) {
  const Index n = features.rows();
  const VectorXd s = log_deviations(features, parameters);
  const VectorXd scaled = scaled_squares(squares, s);
  const VectorXd share = weights / weights.sum();
  const VectorXd slope = share.array() * (1.0 - scaled.array());      // dl/ds
  const VectorXd curvature = 2.0 * (share.array() * scaled.array());  // d2l/ds2
  const MatrixXd curved = features * curvature.asDiagonal();          // n x N
  DeviationLikelihood l{cost_at(s, scaled, weights, parameters, ridge), VectorXd(n + 1), MatrixXd(n + 1, n + 1)};
  l.gradient << features * slope + ridge * parameters.head(n), slope.sum();
  l.hessian.topLeftCorner(n, n).noalias() = curved * features.transpose();
  l.hessian.topLeftCorner(n, n).diagonal().array() += ridge;
  l.hessian.col(n).head(n) = curved.rowwise().sum();
  l.hessian.row(n).head(n) = l.hessian.col(n).head(n).transpose();
  l.hessian(n, n) = curvature.sum();
  return l;
}

VectorXd most_likely_deviation(const MatrixXd& features, const VectorXd& squares, const VectorXd& weights,
                               double ridge) {
  constexpr int kMostSteps = 60, kMostHalvings = 40;
  constexpr double kConverged = 1e-12;  // predicted decrease of a step; l is of order 1
  VectorXd parameters = VectorXd::Zero(features.rows() + 1);
  parameters(features.rows()) = 0.5 * std::log(weights.dot(squares) / weights.sum());
  for (int step = 0; step < kMostSteps; ++step) {
    const DeviationLikelihood l = deviation_likelihood(features, squares, weights, parameters, ridge);
    const VectorXd direction = -codegen::solve_symmetric(l.hessian, l.gradient);
    const double promised = -l.gradient.dot(direction);
    if (!(promised > kConverged)) break;
    double length = 1.0;
    int halvings = 0;
    const auto cost = [&] {
      return deviation_cost(features, squares, weights, parameters + length * direction, ridge);
    };
    while (!(cost() <= l.value - 1e-4 * length * promised) && ++halvings < kMostHalvings) length *= 0.5;
    if (halvings == kMostHalvings) break;
    parameters += length * direction;
  }
  return parameters;
}

}  // namespace nlo::trainer
