// SPDX-License-Identifier: MIT
#include "trainer/plants/plant_channels.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <set>

#include "trainer/base/nearest_name.h"
#include "trainer/config/key_error.h"
#include "trainer/data/angle.h"

namespace nlo::trainer {
namespace {

/// Returns true for each channel that is given as sine and cosine.
std::vector<bool> sincos_of(const std::vector<Encoding>& encodings, const std::vector<Channel>& channels,
                            std::string_view key, std::string_view what) {
  std::vector<bool> sincos(channels.size(), false);
  if (encodings.empty()) return sincos;
  if (encodings.size() != channels.size())
    throw KeyError(fmt::format("plant.{}_encodings", key),
                   fmt::format("[plant] {}_encodings has {} entries, but there are {} {}; give one for each", key,
                               encodings.size(), channels.size(), what));
  for (std::size_t i = 0; i < channels.size(); ++i) {
    sincos[i] = encodings[i] == Encoding::kSincos;
    if (sincos[i] && channels[i].wrap == 0.0)
      throw KeyError(fmt::format("plant.{}_encodings", key),
                     fmt::format("[plant] {0}_encodings[{1}] is \"sincos\", but {2} is not an angle; give its full "
                                 "turn in {0}_wraps, or write \"unwrap\"",
                                 key, i, channels[i].name));
  }
  return sincos;
}

std::size_t index_of(const std::string& name, const std::vector<Channel>& states) {
  std::vector<std::string> known;
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (states[i].name == name) return i;
    known.push_back(states[i].name);
  }
  const std::string nearest = nearest_name(name, known);
  throw KeyError("plant.estimated", fmt::format("[plant] estimated has \"{}\", which is not a state; {}", name,
                                                nearest.empty() ? fmt::format("there are: {}", fmt::join(known, ", "))
                                                                : fmt::format("did you mean \"{}\"?", nearest)));
}

/// Checks that each name is a state, an output or an input.
void check_even(const std::vector<std::string>& even, const Plant& plant) {
  std::vector<std::string> known;
  for (const auto* channels : {&plant.states(), &plant.outputs(), &plant.inputs()})
    for (const Channel& channel : *channels) known.push_back(channel.name);
  for (const std::string& name : even) {
    if (std::ranges::find(known, name) != known.end()) continue;
    const std::string nearest = nearest_name(name, known);
    throw KeyError("plant.even", fmt::format("[plant] even has \"{}\", which is not a state, output or input; {}", name,
                                             nearest.empty() ? fmt::format("there are: {}", fmt::join(known, ", "))
                                                             : fmt::format("did you mean \"{}\"?", nearest)));
  }
}

void check_distinct(const std::vector<Channel>& channels, std::string_view key) {
  std::set<std::string> seen;
  for (const Channel& channel : channels)
    if (!seen.insert(channel.name).second)
      throw KeyError(fmt::format("plant.{}", key),
                     fmt::format("[plant] {} make two channels of the name \"{}\"; rename one", key, channel.name));
}

}  // namespace

PlantChannels::PlantChannels(const PlantConfig& config, const Plant& plant)
    : plant_states_(plant.nx()), plant_outputs_(plant.ny()) {
  const std::vector<bool> state_sincos = sincos_of(config.state_encodings, plant.states(), "state", "states");
  const std::vector<bool> output_sincos = sincos_of(config.output_encodings, plant.outputs(), "output", "outputs");
  std::vector<std::size_t> estimated;
  for (const std::string& name : config.estimated) {
    const std::size_t i = index_of(name, plant.states());
    if (std::find(estimated.begin(), estimated.end(), i) != estimated.end())
      throw KeyError("plant.estimated", fmt::format("[plant] estimated has \"{}\" twice; keep one", name));
    estimated.push_back(i);
  }
  if (estimated.empty())
    for (std::size_t i = 0; i < plant.states().size(); ++i) estimated.push_back(i);
  check_even(config.even, plant);
  for (const std::size_t i : estimated) add(states_, plant.states()[i], static_cast<Eigen::Index>(i), state_sincos[i]);
  for (std::size_t i = 0; i < plant.states().size(); ++i)
    if (std::ranges::find(estimated, i) == estimated.end())
      add(unestimated_, plant.states()[i], static_cast<Eigen::Index>(i), state_sincos[i]);
  for (std::size_t j = 0; j < plant.outputs().size(); ++j)
    add(outputs_, plant.outputs()[j], static_cast<Eigen::Index>(j), output_sincos[j]);
  states_.plain = states_.plain && static_cast<Eigen::Index>(estimated.size()) == plant_states_ &&
                  std::is_sorted(estimated.begin(), estimated.end());
  check_distinct(states_.channels, "state_encodings");
  check_distinct(outputs_.channels, "output_encodings");
}

void PlantChannels::add(Side& side, const Channel& channel, Eigen::Index row, bool sincos) {
  if (!sincos) {
    side.channels.push_back(channel);
    side.sources.push_back({row, Part::kWhole, channel.wrap});
    return;
  }
  side.plain = false;
  side.channels.push_back({channel.name + "_sin", "", 0.0});
  side.channels.push_back({channel.name + "_cos", "", 0.0});
  side.sources.push_back({row, Part::kSine, channel.wrap});
  side.sources.push_back({row, Part::kCosine, channel.wrap});
}

bool PlantChannels::all_states() const {
  std::set<Eigen::Index> rows;
  for (const Source& source : states_.sources) rows.insert(source.row);
  return static_cast<Eigen::Index>(rows.size()) == plant_states_;
}

Eigen::MatrixXd PlantChannels::encoded(const Side& side, const Eigen::MatrixXd& values) {
  Eigen::MatrixXd channels(static_cast<Eigen::Index>(side.sources.size()), values.cols());
  Eigen::Index next = 0;
  for (const auto& [row, part, wrap] : side.sources) {
    const Eigen::VectorXd value = values.row(row);
    if (part == Part::kWhole) channels.row(next++) = value.transpose();
    if (part == Part::kSine) channels.row(next++) = sine_of(value, wrap).transpose();
    if (part == Part::kCosine) channels.row(next++) = cosine_of(value, wrap).transpose();
  }
  return channels;
}

Eigen::MatrixXd PlantChannels::derivatives(const Eigen::MatrixXd& x, const Eigen::MatrixXd& f) const {
  Eigen::MatrixXd result(static_cast<Eigen::Index>(states_.sources.size()), f.cols());
  Eigen::Index next = 0;
  for (const auto& [row, part, wrap] : states_.sources) {
    const Eigen::VectorXd angle = x.row(row);
    auto to = result.row(next++);
    to = f.row(row);
    if (part == Part::kWhole) continue;
    const double radians = 2.0 * std::numbers::pi / wrap;
    const Eigen::VectorXd slope = part == Part::kSine ? cosine_of(angle, wrap) : Eigen::VectorXd(-sine_of(angle, wrap));
    to.array() *= radians * slope.transpose().array();
  }
  return result;
}

Eigen::MatrixXd PlantChannels::plant_outputs(const Eigen::MatrixXd& channels) const {
  if (outputs_.plain) return channels;
  Eigen::MatrixXd y(plant_outputs_, channels.cols());
  for (std::size_t i = 0; i < outputs_.sources.size(); ++i) {
    const auto& [row, part, wrap] = outputs_.sources[i];
    const auto at = static_cast<Eigen::Index>(i);
    if (part == Part::kWhole) y.row(row) = channels.row(at);
    if (part == Part::kSine) y.row(row) = angle_of(channels.row(at), channels.row(at + 1), wrap).transpose();
  }
  return y;
}

void PlantChannels::apply(Dataset& dataset) const {
  if (plain()) return;
  for (Trajectory& run : dataset.trajectories) {
    if (run.derivatives.size() > 0) run.derivatives = derivatives(run.states, run.derivatives);
    if (!unestimated_.sources.empty()) run.unestimated = encoded(unestimated_, run.states);
    run.states = encoded(states_, run.states);
    run.outputs = encoded(outputs_, run.outputs);
  }
  if (Collocation& points = dataset.collocation; points.x.size() > 0) {
    points.f = derivatives(points.x, points.f);
    points.x = encoded(states_, points.x);
    points.h = encoded(outputs_, points.h);
  }
  dataset.states = states_.channels;
  dataset.outputs = outputs_.channels;
  for (std::size_t i = 0; i < outputs_.sources.size(); ++i)
    if (outputs_.sources[i].part == Part::kSine)
      dataset.output_angles.push_back({static_cast<Eigen::Index>(i), outputs_.sources[i].wrap});
}

}  // namespace nlo::trainer
