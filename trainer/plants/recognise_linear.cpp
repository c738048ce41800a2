// SPDX-License-Identifier: MIT
#include "trainer/plants/recognise_linear.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "trainer/base/engine_draws.h"

namespace nlo::trainer {
namespace {

/// Columns of either sign, each entry from a thousandth to a thousand times its scale.
Eigen::MatrixXd random_points(const Eigen::VectorXd& scale) {
  constexpr Eigen::Index kPoints = 400;
  constexpr double kDecades = 3.0;
  std::mt19937_64 engine(1);
  return Eigen::MatrixXd::NullaryExpr(scale.size(), kPoints, [&](Eigen::Index i, Eigen::Index) {
    const double size = scale(i) * std::pow(10.0, kDecades * (2.0 * uniform01(engine) - 1.0));
    return uniform01(engine) < 0.5 ? -size : size;
  });
}

struct AffineFit {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd offset;
  bool fits = false;
};

template <class Function>
AffineFit fit(const Function& function, const Eigen::MatrixXd& points) {
  // An expression of some twenty operations that cancel no more than the sum of their terms.
  constexpr double kRounding = 64.0 * std::numeric_limits<double>::epsilon();
  const Eigen::Index nx = points.rows();
  AffineFit result;
  result.offset = function(Eigen::MatrixXd::Zero(nx, 1));
  result.matrix = function(Eigen::MatrixXd::Identity(nx, nx)).colwise() - result.offset;
  const Eigen::MatrixXd values = function(points);
  const Eigen::MatrixXd left = (values - result.matrix * points).colwise() - result.offset;
  const Eigen::MatrixXd size = result.matrix.cwiseAbs() * points.cwiseAbs() +
                               result.offset.cwiseAbs() * (points.colwise().lpNorm<1>().array() + 1.0).matrix();
  result.fits = (left.array().abs() <= kRounding * size.array()).all();  // not where a value is no number
  return result;
}

}  // namespace

Linearity recognise_linear(const Plant& plant, const Eigen::VectorXd& scale) {
  const Eigen::MatrixXd points = random_points(scale);
  const AffineFit f = fit([&](const Eigen::MatrixXd& x) { return plant.derivative(x); }, points);
  const AffineFit h = fit([&](const Eigen::MatrixXd& x) { return plant.output(x); }, points);
  if (!f.fits || !h.fits) return {};
  if (!f.offset.isZero(0.0) || !h.offset.isZero(0.0)) return {nullptr, true};
  return {std::make_unique<LinearPlant>(plant.name(), plant.states(), plant.outputs(), f.matrix, h.matrix), false};
}

}  // namespace nlo::trainer
