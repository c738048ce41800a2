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

constexpr Eigen::Index kStates = 64;
constexpr double kCancelled = 1e-9;  // relative to the largest value among all states: sums of terms that cancel

/// -1 for each channel, 1 where it is declared even.
Eigen::VectorXd signs_of(const std::vector<codegen::Channel>& channels, const std::vector<std::string>& even) {
  Eigen::VectorXd signs = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(channels.size()), -1.0);
  for (std::size_t i = 0; i < channels.size(); ++i)
    if (std::ranges::find(even, channels[i].name) != even.end()) signs(static_cast<Eigen::Index>(i)) = 1.0;
  return signs;
}

std::optional<std::string> difference(const char* what, const std::vector<codegen::Channel>& channels,
                                      const Eigen::VectorXd& signs, bool all_turn, const Eigen::MatrixXd& x,
                                      const Eigen::MatrixXd& u, const Eigen::MatrixXd& at_x,
                                      const Eigen::MatrixXd& at_mirrored) {
  const Eigen::MatrixXd wanted = signs.asDiagonal() * at_x;
  for (Eigen::Index i = 0; i < at_x.rows(); ++i) {
    const double scale = at_x.row(i).cwiseAbs().maxCoeff() + at_mirrored.row(i).cwiseAbs().maxCoeff();
    Eigen::Index worst = 0;
    const double off = (wanted.row(i) - at_mirrored.row(i)).cwiseAbs().maxCoeff(&worst);
    if (!std::isfinite(scale) || off <= kCancelled * scale) continue;  // outside of f's domain nothing can be said
    return fmt::format(
        "the plant is not odd: at x = ({:.3g}){} {} of {} is {:.4g}, and at {} it is {:.4g} where an odd plant has "
        "{:.4g}",
        fmt::join(x.col(worst), ", "),
        u.size() == 0 ? "" : fmt::format(", u = ({:.3g})", fmt::join(u.col(worst), ", ")), what,
        channels[static_cast<std::size_t>(i)].name, at_x(i, worst),
        !all_turn       ? "its mirror image"
        : u.size() == 0 ? "-x"
                        : "-x, -u",
        at_mirrored(i, worst), wanted(i, worst));
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> odd_counterexample(const Plant& plant, const std::vector<std::string>& even,
                                              const SimulationConfig& simulation, bool driven) {
  // About the initial states, twice as far out, as these may be one point. Any seed will do: an equation that is not
  // odd shows it almost everywhere.
  const std::uint64_t seed = initial_state_seed(1, SeedStream::kCollocation);
  Eigen::MatrixXd x = draw_initial_states(simulation, seed, kStates);
  const Eigen::VectorXd furthest = x.cwiseAbs().rowwise().maxCoeff();
  const Eigen::VectorXd reach = (furthest.array() > 0.0).select(2.0 * furthest, 1.0);
  SimulationConfig around;
  around.initial_low.assign(static_cast<std::size_t>(plant.nx()), -1.0);
  around.initial_high.assign(static_cast<std::size_t>(plant.nx()), 1.0);
  x += reach.asDiagonal() * draw_initial_states(around, seed + 1, kStates);
  const Eigen::VectorXd turns = signs_of(plant.states(), even);
  const Eigen::MatrixXd mirrored = turns.asDiagonal() * x;
  // An input whose sign must stay shows at any size.
  SimulationConfig unit;
  unit.initial_low.assign(driven ? plant.inputs().size() : 0, -1.0);
  unit.initial_high.assign(driven ? plant.inputs().size() : 0, 1.0);
  const Eigen::MatrixXd u = driven ? draw_initial_states(unit, seed + 2, kStates) : Eigen::MatrixXd();
  const Eigen::MatrixXd turned_u =
      driven ? Eigen::MatrixXd(signs_of(plant.inputs(), even).asDiagonal() * u) : Eigen::MatrixXd();
  const auto slope = [&](const Eigen::MatrixXd& at, const Eigen::MatrixXd& with) {
    return driven ? plant.driven_derivative(at, with) : plant.derivative(at);
  };
  if (auto found =
          difference("dx/dt", plant.states(), turns, even.empty(), x, u, slope(x, u), slope(mirrored, turned_u)))
    return found;
  return difference("the output", plant.outputs(), signs_of(plant.outputs(), even), even.empty(), x, {},
                    plant.output(x), plant.output(mirrored));
}

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

namespace {

/// The box's points that g is compared at: the same in every run.
Eigen::MatrixXd check_points(const Eigen::VectorXd& low, const Eigen::VectorXd& high) {
  constexpr Eigen::Index kPoints = 256;
  SimulationConfig box;
  box.initial_low.assign(low.begin(), low.end());
  box.initial_high.assign(high.begin(), high.end());
  return draw_initial_states(box, 1, kPoints);
}

/// f(x, u) that is not affine in u has no input field: f(x, e_j) - f(x, 0) would miss it at every other u.
void refuse_curved_inputs(const Plant& plant, const Eigen::MatrixXd& points) {
  if (plant.affine_in_inputs()) return;
  constexpr double kRounding = 1e-9;  // of the differences above: some 1e-15 of the size of f
  SimulationConfig inputs;
  inputs.initial_low.assign(static_cast<std::size_t>(plant.nu()), -2.0);
  inputs.initial_high.assign(static_cast<std::size_t>(plant.nu()), 2.0);
  const Eigen::MatrixXd u = draw_initial_states(inputs, 2, points.cols());
  const Eigen::MatrixXd exact = plant.driven_derivative(points, u);
  const Eigen::MatrixXd affine = plant.Plant::driven_derivative(points, u);
  Eigen::Index row = 0, column = 0;
  const double most = (exact - affine).cwiseAbs().maxCoeff<Eigen::PropagateNaN>(&row, &column);
  if (most <= kRounding * std::max(1.0, exact.cwiseAbs().maxCoeff())) return;
  throw codegen::Error(fmt::format(
      "plant {}: f(x, u) is not affine in its inputs: at x = ({}), u = ({}) it is {:.3g} off f(x) + g(x) u; a driven "
      "observer carries g(x) = W x + b: call what acts linearly the input (u^2 as v), or take another structure",
      plant.name(), fmt::join(points.col(column), ", "), fmt::join(u.col(column), ", "), most));
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

  refuse_curved_inputs(plant, points);

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
