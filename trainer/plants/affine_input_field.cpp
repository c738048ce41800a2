// SPDX-License-Identifier: MIT
#include "trainer/plants/affine_input_field.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "codegen/base/error.h"
#include "trainer/plants/initial_states.h"

namespace nlo::trainer {
namespace {

/// The box's points that g is compared at: the same in every run.
Eigen::MatrixXd check_points(const Eigen::VectorXd& low, const Eigen::VectorXd& high) {
  constexpr Eigen::Index kPoints = 256;
  SimulationConfig box;
  box.initial_low.assign(low.begin(), low.end());
  box.initial_high.assign(high.begin(), high.end());
  return draw_initial_states(box, 1, kPoints);
}

}  // namespace

codegen::DenseLayer affine_input_field(const Plant& plant, const Eigen::VectorXd& low, const Eigen::VectorXd& high) {
  if (plant.nu() == 0) throw codegen::Error(fmt::format("plant {} has no input, so no input field", plant.name()));
  const Eigen::Index nx = plant.nx();
  const Eigen::VectorXd centre = 0.5 * (low + high);
  // A state that starts at one value moves on from there: W needs its slope too.
  const Eigen::Array<bool, Eigen::Dynamic, 1> wide = high.array() > low.array();
  const Eigen::VectorXd half_width = wide.select(0.5 * (high - low), 1.0);
  const Eigen::MatrixXd offsets = half_width.asDiagonal();
  const Eigen::MatrixXd points =
      check_points(wide.select(low, centre - half_width), wide.select(high, centre + half_width));

  codegen::DenseLayer field{Eigen::MatrixXd(nx * plant.nu(), nx), Eigen::VectorXd(nx * plant.nu())};
  for (Eigen::Index j = 0; j < plant.nu(); ++j) {
    auto weights = field.weights.middleRows(j * nx, nx);
    auto bias = field.bias.segment(j * nx, nx);
    weights = (plant.input_field(offsets.colwise() + centre, j) - plant.input_field((-offsets).colwise() + centre, j)) *
              (0.5 * half_width.cwiseInverse()).asDiagonal();
    bias = plant.input_field(centre, j) - weights * centre;

    constexpr double kRounding = 1e-9;  // of an affine g: some 1e-15 of its size
    const Eigen::MatrixXd g = plant.input_field(points, j);
    const Eigen::ArrayXXd deviation = ((weights * points).colwise() + bias - g).cwiseAbs();
    Eigen::Index row = 0, column = 0;
    const double most = deviation.maxCoeff<Eigen::PropagateNaN>(&row, &column);
    if (most <= kRounding * std::max(1.0, g.cwiseAbs().maxCoeff())) continue;
    throw codegen::Error(fmt::format(
        "plant {}: the field of input {} is not affine in the state: at x = ({}) it misses the affine fit by {:.3g}; a "
        "driven observer carries g(x) = W x + b, so take a smaller box, or states in which g is affine",
        plant.name(), plant.inputs()[static_cast<std::size_t>(j)].name, fmt::join(points.col(column), ", "), most));
  }
  return field;
}

}  // namespace nlo::trainer
