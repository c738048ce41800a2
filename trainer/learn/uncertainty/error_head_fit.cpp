// SPDX-License-Identifier: MIT
#include "trainer/learn/uncertainty/error_head_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "codegen/base/error.h"
#include "trainer/learn/uncertainty/calibration.h"
#include "trainer/learn/uncertainty/deviation_likelihood.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Ridges for the weights of features with unit deviation, where the likelihood is of order 1. Logs are few and similar,
// so a head that fits all their details is wrong on the next log.
constexpr double kRidges[] = {1e-4, 1e-3, 1e-2, 1e-1, 1.0};
// Smaller errors count as this share of their root mean square, because errors of zero have no likelihood.
constexpr double kSmallestError = 1e-4;
constexpr double kMostLog = 50.0;  // largest |log sigma|, within the limits of a model file

/// Features with unit deviation, and the shift and scale that made them.
struct Standardised {
  VectorXd mean, scale;
  MatrixXd features;  ///< n x N

  Standardised(const MatrixXd& all, const VectorXd& share) : mean(all * share), features(all.colwise() - mean) {
    scale = (features.cwiseAbs2() * share).cwiseSqrt();
    for (double& value : scale)
      if (!(value > 1e-6)) value = 1.0;  // a constant feature
    features = (scale.cwiseInverse().asDiagonal() * features).eval();
  }
};

/// Returns r^2 of state i plus a small number, because errors of zero have no likelihood.
VectorXd squares_of(const ErrorSamples& samples, const VectorXd& weights, Index i) {
  const VectorXd squares = samples.errors.row(i).cwiseAbs2();
  const double power = std::max(weights.dot(squares) / weights.sum(), 1e-30);
  return squares.array() + kSmallestError * kSmallestError * power;
}

/// Sets row i of the head from parameters for standardised features.
void set_row(codegen::ErrorHead& head, Index i, const Standardised& x, const VectorXd& parameters,
             const VectorXd& weights, double largest_error) {
  const Index n = x.scale.size();
  const VectorXd slopes = parameters.head(n).cwiseQuotient(x.scale);
  head.weights.row(i) = slopes;
  head.bias(i) = parameters(n) - slopes.dot(x.mean);
  const double most = std::clamp(std::log(largest_error), -kMostLog, kMostLog);
  double low = most, high = -kMostLog;
  for (Index k = 0; k < x.features.cols(); ++k) {
    if (weights(k) == 0.0) continue;
    const double s = std::clamp(x.features.col(k).dot(parameters.head(n)) + parameters(n), -kMostLog, most);
    low = std::min(low, s);
    high = std::max(high, s);
  }
  head.log_min(i) = low;
  head.log_max(i) = high;
}

/// Returns minus the log likelihood of state i, divided by the sum of the weights.
double cost_of(const codegen::ErrorHead& head, const ErrorSamples& samples, const VectorXd& weights, Index i) {
  const VectorXd sigma = deviations_everywhere(head, samples).row(i);
  const VectorXd squares = squares_of(samples, weights, i);
  return weights.dot((sigma.array().log() + 0.5 * squares.array() / sigma.array().square()).matrix()) / weights.sum();
}

}  // namespace

codegen::ErrorHead fit_error_head(const ErrorSamples& training, const ErrorSamples& validation) {
  if (training.size() == 0 || validation.size() == 0)
    throw codegen::Error(
        "the error head cannot be fitted, because the truth of every sample is masked: unmask some samples");
  const VectorXd weights = training.known_weights(), validation_weights = validation.known_weights();
  const Standardised x(codegen::error_features(training.hidden), weights / weights.sum());
  const Index nx = training.errors.rows(), n = x.scale.size();
  codegen::ErrorHead head{MatrixXd::Zero(nx, n), VectorXd::Zero(nx), VectorXd::Zero(nx),
                          VectorXd::Zero(nx),    VectorXd::Ones(nx), VectorXd::Constant(nx, kNormal95)};
  for (Index i = 0; i < nx; ++i) {
    const VectorXd squares = squares_of(training, weights, i);
    const double largest = std::sqrt((weights.array() > 0.0).select(squares, 0.0).maxCoeff());
    codegen::ErrorHead candidate = head;
    double least = std::numeric_limits<double>::infinity();
    for (const double ridge : kRidges) {
      set_row(candidate, i, x, most_likely_deviation(x.features, squares, weights, ridge), weights, largest);
      const double cost = cost_of(candidate, validation, validation_weights, i);
      if (!(cost < least)) continue;
      least = cost;
      head = candidate;
    }
  }
  return head;
}

}  // namespace nlo::trainer
