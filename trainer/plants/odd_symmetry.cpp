// SPDX-License-Identifier: MIT
#include "trainer/plants/odd_symmetry.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "trainer/plants/initial_states.h"

namespace nlo::trainer {

namespace {

constexpr Eigen::Index kStates = 64;
constexpr double kRounding = 1e-9;  // relative to the largest value among all states: sums of terms that cancel

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
    if (!std::isfinite(scale) || off <= kRounding * scale) continue;  // outside of f's domain nothing can be said
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

}  // namespace nlo::trainer
