// SPDX-License-Identifier: MIT
#include "trainer/plants/plant_symmetry.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "trainer/base/engine_draws.h"
#include "trainer/plants/initial_states.h"
#include "trainer/symmetry/symmetry.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr Index kStates = 64;
constexpr int kDrawn = 4;            // elements beside those that stand for all
constexpr double kCancelled = 1e-9;  // relative to the largest value among all states: sums of terms that cancel

/// A state, and its image.
struct Points {
  MatrixXd x, u;

  std::string text(Index at) const {
    return fmt::format("x = ({:.3g}){}", fmt::join(x.col(at), ", "),
                       u.size() == 0 ? "" : fmt::format(", u = ({:.3g})", fmt::join(u.col(at), ", ")));
  }
};

MatrixXd drawn_box(std::size_t rows, std::uint64_t seed) {
  SimulationConfig box;
  box.initial_low.assign(rows, -1.0);
  box.initial_high.assign(rows, 1.0);
  return draw_initial_states(box, seed, kStates);
}

/// About the initial states, twice as far out, as these may be one point. Any seed will do: an equation that does not
/// hold shows it almost everywhere. An input shows at any size.
Points points_about(const SimulationConfig& simulation, const Plant& plant, bool driven) {
  const std::uint64_t seed = initial_state_seed(1, SeedStream::kCollocation);
  MatrixXd x = draw_initial_states(simulation, seed, kStates);
  const Eigen::VectorXd furthest = x.cwiseAbs().rowwise().maxCoeff();
  const Eigen::VectorXd reach = (furthest.array() > 0.0).select(2.0 * furthest, 1.0);
  x += reach.asDiagonal() * drawn_box(plant.states().size(), seed + 1);
  return {std::move(x), driven ? drawn_box(plant.inputs().size(), seed + 2) : MatrixXd()};
}

/// Of an equation whose value at the points is turned into `wanted`, and which has `found` at their images.
///   wraps  a full turn of an angle is no difference
std::optional<std::string> difference(const char* what, const std::vector<codegen::Channel>& channels,
                                      const Points& points, const Points& images, const MatrixXd& value,
                                      const MatrixXd& wanted, const MatrixXd& found, bool wraps) {
  for (Index i = 0; i < value.rows(); ++i) {
    const double scale = wanted.row(i).cwiseAbs().maxCoeff() + found.row(i).cwiseAbs().maxCoeff();
    const double turn = wraps ? channels[static_cast<std::size_t>(i)].wrap : 0.0;
    Eigen::RowVectorXd apart = wanted.row(i) - found.row(i);
    if (turn > 0.0) apart -= turn * (apart / turn).array().round().matrix();
    Index worst = 0;
    const double off = apart.cwiseAbs().maxCoeff(&worst);
    if (!std::isfinite(scale) || off <= kCancelled * scale) continue;  // outside of f's domain nothing can be said
    return fmt::format("at {} {} of {} is {:.4g}, and at the image {} it is {:.4g} where the symmetry has {:.4g}",
                       points.text(worst), what, channels[static_cast<std::size_t>(i)].name, value(i, worst),
                       images.text(worst), found(i, worst), wanted(i, worst));
  }
  return std::nullopt;
}

}  // namespace

SymmetryConfig odd_symmetry(const Plant& plant, const std::vector<std::string>& even) {
  SymmetryConfig symmetry{.kind = "sign"};
  for (const auto* channels : {&plant.states(), &plant.outputs(), &plant.inputs()})
    for (const codegen::Channel& channel : *channels)
      if (std::ranges::find(even, channel.name) == even.end() &&
          std::ranges::find(symmetry.channels, channel.name) == symmetry.channels.end())
        symmetry.channels.push_back(channel.name);
  return symmetry;
}

std::optional<std::string> symmetry_counterexample(const Plant& plant, const SymmetryConfig& config,
                                                   const SimulationConfig& simulation, bool driven) {
  const Points points = points_about(simulation, plant, driven);
  const auto slope = [&](const Points& at) {
    return driven ? plant.driven_derivative(at.x, at.u) : plant.derivative(at.x);
  };
  const MatrixXd f = slope(points), h = plant.output(points.x);
  const Symmetry states = on_channels(config, plant.inputs(), plant.states());
  const Symmetry outputs = on_channels(config, plant.outputs(), {});
  std::vector<Element> elements = states.kind->others(states.components, states.fold);
  std::mt19937_64 engine(1);
  const Uniform uniform = [&] { return static_cast<float>(uniform01(engine)); };
  for (int i = 0; i < kDrawn; ++i) elements.push_back(states.kind->draw(states.components, states.fold, uniform));
  for (const Element& element : elements) {
    const Image image = image_of(states, element, static_cast<int>(plant.nu()), static_cast<int>(plant.nx()));
    const RowMap on_outputs = image_of(outputs, element, static_cast<int>(plant.ny()), 0).readings;
    const Points images{image.states.values(points.x), driven ? image.readings.values(points.u) : MatrixXd()};
    if (auto found =
            difference("dx/dt", plant.states(), points, images, f, image.states.derivatives(f), slope(images), false))
      return found;
    if (auto found = difference("the output", plant.outputs(), {points.x, {}}, {images.x, {}}, h, on_outputs.values(h),
                                plant.output(images.x), true))
      return found;
  }
  return std::nullopt;
}

}  // namespace nlo::trainer
