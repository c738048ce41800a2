// SPDX-License-Identifier: MIT
#include "trainer/plants/odd_plant.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "trainer/data/mirror.h"
#include "trainer/plants/initial_states.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr Index kStates = 64;
// Tolerance relative to the largest value over all states, because terms of a sum may cancel.
constexpr double kCancelled = 1e-9;

/// A state and its mirror image.
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

/// Returns points around the initial states, up to twice as far from their centre; there may be only one initial state.
/// Any seed and any size of the inputs will do, because an equation that is not odd differs almost everywhere.
Points points_about(const SimulationConfig& simulation, const Plant& plant, bool driven) {
  const std::uint64_t seed = initial_state_seed(1, SeedStream::kCollocation);
  MatrixXd x = draw_initial_states(simulation, seed, kStates);
  const Eigen::VectorXd furthest = x.cwiseAbs().rowwise().maxCoeff();
  const Eigen::VectorXd reach = (furthest.array() > 0.0).select(2.0 * furthest, 1.0);
  x += reach.asDiagonal() * drawn_box(plant.states().size(), seed + 1);
  return {std::move(x), driven ? drawn_box(plant.inputs().size(), seed + 2) : MatrixXd()};
}

/// Returns `values`, a row for each of `channels`, with the sign of the rows in `odd` changed.
MatrixXd mirrored(const std::vector<std::string>& odd, const std::vector<codegen::Channel>& channels, MatrixXd values) {
  const Mirror mirror = mirror_of(odd, channels, {});
  for (Index row = 0; row < values.rows() && !mirror.none(); ++row)
    values.row(row) *= static_cast<double>(mirror.of_reading(static_cast<std::size_t>(row)));
  return values;
}

/// Describes where `found`, the values of an equation at the mirror images of the points, differs from `wanted`, the
/// mirror images of its values at the points.
///   wraps  a difference of full turns of an angle does not count
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
    if (!std::isfinite(scale) || off <= kCancelled * scale) continue;  // skips points outside of the domain of f
    return fmt::format(
        "at {} {} of {} is {:.4g}, and at the mirror image {} it is {:.4g}, but an odd plant would have {:.4g}",
        points.text(worst), what, channels[static_cast<std::size_t>(i)].name, value(i, worst), images.text(worst),
        found(i, worst), wanted(i, worst));
  }
  return std::nullopt;
}

}  // namespace

std::vector<std::string> odd_channels(const Plant& plant, const std::vector<std::string>& even) {
  std::vector<std::string> odd;
  for (const auto* channels : {&plant.states(), &plant.outputs(), &plant.inputs()})
    for (const codegen::Channel& channel : *channels)
      if (std::ranges::find(even, channel.name) == even.end() && std::ranges::find(odd, channel.name) == odd.end())
        odd.push_back(channel.name);
  return odd;
}

std::optional<std::string> mirror_counterexample(const Plant& plant, const std::vector<std::string>& odd,
                                                 const SimulationConfig& simulation, bool driven) {
  const Points points = points_about(simulation, plant, driven);
  const auto slope = [&](const Points& at) {
    return driven ? plant.driven_derivative(at.x, at.u) : plant.derivative(at.x);
  };
  const MatrixXd f = slope(points), h = plant.output(points.x);
  const Points images{mirrored(odd, plant.states(), points.x),
                      driven ? mirrored(odd, plant.inputs(), points.u) : MatrixXd()};
  if (auto found = difference("dx/dt", plant.states(), points, images, f, mirrored(odd, plant.states(), f),
                              slope(images), false))
    return found;
  return difference("the output", plant.outputs(), {points.x, {}}, {images.x, {}}, h, mirrored(odd, plant.outputs(), h),
                    plant.output(images.x), true);
}

}  // namespace nlo::trainer
