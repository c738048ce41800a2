// SPDX-License-Identifier: MIT
#include "trainer/plants/odd_symmetry.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <vector>

#include "trainer/plants/initial_states.h"

namespace nlo::trainer {

namespace {

constexpr Eigen::Index kStates = 64;
constexpr double kRounding = 1e-9;  // relative to the largest value among all states: sums of terms that cancel

std::optional<std::string> difference(const char* what, const std::vector<codegen::Channel>& channels,
                                      const Eigen::MatrixXd& x, const Eigen::MatrixXd& at_x,
                                      const Eigen::MatrixXd& at_minus_x) {
  for (Eigen::Index i = 0; i < at_x.rows(); ++i) {
    const double scale = at_x.row(i).cwiseAbs().maxCoeff() + at_minus_x.row(i).cwiseAbs().maxCoeff();
    Eigen::Index worst = 0;
    const double sum = (at_x.row(i) + at_minus_x.row(i)).cwiseAbs().maxCoeff(&worst);
    if (!std::isfinite(scale) || sum <= kRounding * scale) continue;  // outside of f's domain nothing can be said
    return fmt::format(
        "the plant is not odd: at x = ({:.3g}) {} of {} is {:.4g}, and at -x it is {:.4g} where an odd plant has "
        "{:.4g}",
        fmt::join(x.col(worst), ", "), what, channels[static_cast<std::size_t>(i)].name, at_x(i, worst),
        at_minus_x(i, worst), -at_x(i, worst));
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> odd_counterexample(const Plant& plant, const SimulationConfig& simulation) {
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
  const Eigen::MatrixXd mirrored = -x;
  if (auto found = difference("dx/dt", plant.states(), x, plant.derivative(x), plant.derivative(mirrored)))
    return found;
  return difference("the output", plant.outputs(), x, plant.output(x), plant.output(mirrored));
}

}  // namespace nlo::trainer
