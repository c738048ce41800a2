// SPDX-License-Identifier: MIT
#include "trainer/plants/plant_form.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "codegen/base/error.h"
#include "trainer/base/engine_draws.h"
#include "trainer/plants/initial_states.h"

namespace nlo::trainer {
namespace {

/// Returns columns of either sign, each entry from a thousandth to a thousand times its scale.
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
  // Rounding of an expression with some twenty operations, without more cancellation than in the sum of its terms.
  constexpr double kRounding = 64.0 * std::numeric_limits<double>::epsilon();
  const Eigen::Index nx = points.rows();
  AffineFit result;
  result.offset = function(Eigen::MatrixXd::Zero(nx, 1));
  result.matrix = function(Eigen::MatrixXd::Identity(nx, nx)).colwise() - result.offset;
  const Eigen::MatrixXd values = function(points);
  const Eigen::MatrixXd left = (values - result.matrix * points).colwise() - result.offset;
  const Eigen::MatrixXd size = result.matrix.cwiseAbs() * points.cwiseAbs() +
                               result.offset.cwiseAbs() * (points.colwise().lpNorm<1>().array() + 1.0).matrix();
  result.fits = (left.array().abs() <= kRounding * size.array()).all();  // false if a value is NaN
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

namespace {

/// Returns the points of the box at which g is compared, the same in every run.
Eigen::MatrixXd check_points(const Eigen::VectorXd& low, const Eigen::VectorXd& high) {
  constexpr Eigen::Index kPoints = 256;
  SimulationConfig box;
  box.initial_low.assign(low.begin(), low.end());
  box.initial_high.assign(high.begin(), high.end());
  return draw_initial_states(box, 1, kPoints);
}

/// Throws if f(x, u) is not affine in u. Such a plant has no input field: f(x, e_j) - f(x, 0) would be wrong at every
/// other u.
void refuse_curved_inputs(const Plant& plant, const Eigen::MatrixXd& points) {
  if (plant.affine_in_inputs()) return;
  constexpr double kRounding = 1e-9;  // bounds the rounding of the differences above, some 1e-15 of the size of f
  SimulationConfig inputs;
  inputs.initial_low.assign(static_cast<std::size_t>(plant.nu()), -2.0);
  inputs.initial_high.assign(static_cast<std::size_t>(plant.nu()), 2.0);
  const Eigen::MatrixXd u = draw_initial_states(inputs, 2, points.cols());
  const Eigen::MatrixXd exact = plant.driven_derivative(points, u);
  const Eigen::MatrixXd affine = plant.Plant::driven_derivative(points, u);
  Eigen::Index row = 0, column = 0;
  const double most = (exact - affine).cwiseAbs().maxCoeff<Eigen::PropagateNaN>(&row, &column);
  if (most <= kRounding * std::max(1.0, exact.cwiseAbs().maxCoeff())) return;
  throw codegen::Error(
      fmt::format("plant {}: f(x, u) is not affine in its inputs: at x = ({}), u = ({}) it differs from f(x) + g(x) u "
                  "by {:.3g}, but a driven observer needs g(x) = W x + b; define as input the quantity that acts "
                  "linearly (v = u^2), or choose another structure",
                  plant.name(), fmt::join(points.col(column), ", "), fmt::join(u.col(column), ", "), most));
}

}  // namespace

codegen::DenseLayer affine_input_field(const Plant& plant, const Eigen::VectorXd& low, const Eigen::VectorXd& high) {
  if (plant.nu() == 0) throw codegen::Error(fmt::format("plant {} has no input, so no input field", plant.name()));
  const Eigen::Index nx = plant.nx();
  const Eigen::VectorXd centre = 0.5 * (low + high);
  // A state with a single initial value also moves during a run, so W needs its slope too.
  const Eigen::Array<bool, Eigen::Dynamic, 1> wide = high.array() > low.array();
  const Eigen::VectorXd half_width = wide.select(0.5 * (high - low), 1.0);
  const Eigen::MatrixXd offsets = half_width.asDiagonal();
  const Eigen::MatrixXd points =
      check_points(wide.select(low, centre - half_width), wide.select(high, centre + half_width));

  refuse_curved_inputs(plant, points);

  codegen::DenseLayer field{Eigen::MatrixXd(nx * plant.nu(), nx), Eigen::VectorXd(nx * plant.nu())};
  for (Eigen::Index j = 0; j < plant.nu(); ++j) {
    auto weights = field.weights.middleRows(j * nx, nx);
    auto bias = field.bias.segment(j * nx, nx);
    weights = (plant.input_field(offsets.colwise() + centre, j) - plant.input_field((-offsets).colwise() + centre, j)) *
              (0.5 * half_width.cwiseInverse()).asDiagonal();
    bias = plant.input_field(centre, j) - weights * centre;

    constexpr double kRounding = 1e-9;  // bounds the rounding of an affine g, some 1e-15 of its size
    const Eigen::MatrixXd g = plant.input_field(points, j);
    const Eigen::ArrayXXd deviation = ((weights * points).colwise() + bias - g).cwiseAbs();
    Eigen::Index row = 0, column = 0;
    const double most = deviation.maxCoeff<Eigen::PropagateNaN>(&row, &column);
    if (most <= kRounding * std::max(1.0, g.cwiseAbs().maxCoeff())) continue;
    throw codegen::Error(fmt::format(
        "plant {}: the field of input {} is not affine in the state: at x = ({}) it differs from the affine fit by "
        "{:.3g}, but a driven observer needs g(x) = W x + b; use a smaller box, or states in which g is affine",
        plant.name(), plant.inputs()[static_cast<std::size_t>(j)].name, fmt::join(points.col(column), ", "), most));
  }
  return field;
}

}  // namespace nlo::trainer
