// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "trainer/base/nearest_name.h"
#include "trainer/config/key_error.h"
#include "trainer/experiments/checks.h"
#include "trainer/experiments/observer_channels.h"
#include "trainer/experiments/symmetries.h"
#include "trainer/plants/plant_symmetry.h"
#include "trainer/plants/registry.h"
#include "trainer/structures/table.h"
#include "trainer/symmetry/symmetry.h"

namespace nlo::trainer {
namespace {

using Refuse = std::function<void(const std::string& why)>;  ///< throws

/// Channels of one role, one of which a vector has all components of or none.
struct Side {
  std::string what;
  std::vector<Channel> channels;

  const Channel* find(const std::string& name) const {
    const auto found = std::ranges::find(channels, name, &Channel::name);
    return found == channels.end() ? nullptr : &*found;
  }
  bool has_encoded(const std::string& name) const { return find(name + "_sin") != nullptr; }
};

/// What the observer has, and what a plant has beside that: hidden states.
std::vector<Side> sides_of(const Experiment& e, const Plant* plant) {
  const ChannelCounts own = observer_channels(e);
  std::vector<Side> sides = {{"an estimated state", own.state_channels},
                             {"an output", own.output_channels},
                             {"an input", own.read_input_channels}};
  if (plant == nullptr) return sides;
  sides.push_back({"a state of the plant", plant->states()});
  sides.push_back({"an output of the plant", plant->outputs()});
  sides.push_back({"an input of the plant", plant->inputs()});
  return sides;
}

void check_names(const SymmetryConfig& s, const std::vector<Side>& sides, const Refuse& refuse) {
  std::vector<std::string> names = s.channels;
  for (const std::vector<std::string>& vector : s.vectors) names.insert(names.end(), vector.begin(), vector.end());
  if (names.empty()) refuse("moves nothing; name what it moves");
  for (const std::string& name : names) {
    if (std::ranges::count(names, name) > 1) refuse(fmt::format("names \"{}\" twice; keep one", name));
    std::vector<std::string> known;
    bool found = false;
    for (const Side& side : sides) {
      for (const Channel& channel : side.channels) known.push_back(channel.name);
      found = found || side.find(name) != nullptr || side.has_encoded(name);
      if (const Channel* channel = side.find(name); channel != nullptr && !channel->expression.empty())
        refuse(fmt::format("names {}, which is computed of what is measured and turns with it; leave it out", name));
    }
    if (found) continue;
    const std::string nearest = nearest_name(name, known);
    refuse(fmt::format("names \"{}\", which is not an output, an input or a state; {}", name,
                       nearest.empty() ? fmt::format("there are: {}", fmt::join(known, ", "))
                                       : fmt::format("did you mean \"{}\"?", nearest)));
  }
}

void check_shape(const SymmetryConfig& s, const Refuse& refuse) {
  if (s.kind.empty()) refuse(fmt::format("has no kind; write one of {}", fmt::join(symmetry_kind_names(), ", ")));
  const SymmetryKind& kind = symmetry_kind(s.kind);
  if (kind.components == kNoVectors && !s.vectors.empty()) refuse("has no vectors; name its channels");
  if (kind.channels == SymmetryKind::Channels::kNone && !s.channels.empty())
    refuse("has no channels; name its vectors, each by its components");
  if (s.fold > 0 && kind.channels != SymmetryKind::Channels::kAngles)
    refuse("has no fold, which is of a turn; remove it");
  for (const std::vector<std::string>& vector : s.vectors) {
    const std::size_t wanted = kind.components != kAnyLength ? static_cast<std::size_t>(kind.components)
                                                             : std::max<std::size_t>(2, s.vectors.front().size());
    if (vector.size() != wanted)
      refuse(
          fmt::format("has the vector ({}); each of its vectors has {} components", fmt::join(vector, ", "), wanted));
  }
}

void check_vectors(const SymmetryConfig& s, const std::vector<Side>& sides, const Refuse& refuse) {
  for (const std::vector<std::string>& vector : s.vectors)
    for (const Side& side : sides) {
      const auto is_there = [&](const std::string& name) { return side.find(name) != nullptr; };
      const auto some = std::ranges::find_if(vector, is_there), other = std::ranges::find_if_not(vector, is_there);
      if (some == vector.end()) continue;
      if (other != vector.end())
        refuse(fmt::format("turns {} and {} into each other, and {} is {} where {} is not one", *some, *other, *some,
                           side.what, *other));
      const Channel& first = *side.find(vector.front());
      for (const std::string& name : vector) {
        const Channel& channel = *side.find(name);
        if (channel.unit != first.unit)
          refuse(fmt::format("turns {} [{}] and {} [{}] into each other; components of a vector have one unit",
                             first.name, first.unit, name, channel.unit));
        if (channel.wrap > 0.0)
          refuse(fmt::format(
              "has the angle {} as a component of a vector; an angle is one of its channels, or left out", name));
      }
    }
}

void check_moved_angles(const SymmetryConfig& s, const std::vector<Side>& sides, const Refuse& refuse) {
  if (symmetry_kind(s.kind).channels != SymmetryKind::Channels::kAngles) return;
  for (const std::string& name : s.channels)
    for (const Side& side : sides) {
      const Channel* channel = side.find(name);
      if (channel == nullptr) continue;
      if (channel->wrap == 0.0)
        refuse(
            fmt::format("moves {}, which is not an angle; give its full turn (wrap, state_wraps, output_wraps)", name));
      if (&side == &sides.front())
        refuse(
            fmt::format("moves the estimated state {}, and no function of z counts turns; set its encoding to "
                        "\"sincos\"",
                        name));
    }
}

/// What is the derivative of a column turns as that does.
void check_derivatives(const SymmetryConfig& s, const LogConfig& log, const Refuse& refuse) {
  const auto place = [&](const std::string& name) {
    for (const std::vector<std::string>& vector : s.vectors)
      for (std::size_t i = 0; i < vector.size(); ++i)
        if (vector[i] == name) return static_cast<int>(i) + 1;
    const bool scalar = symmetry_kind(s.kind).channels == SymmetryKind::Channels::kScalars;
    return scalar && std::ranges::find(s.channels, name) != s.channels.end() ? 1 : 0;
  };
  for (const ColumnConfig& column : log.columns)
    for (const ColumnConfig& source : log.columns)
      if (source.name == column.derivative_of && source.derivative_of.empty() &&
          place(column.name) != place(source.name))
        refuse(
            fmt::format("does not turn {} and {} alike, and the one is the derivative of the other; name both, in the "
                        "same place of a vector, or none (of mirror: odd = true or false for both)",
                        column.name, source.name));
}

/// The equations, where they are known.
std::optional<std::string> counterexample(const Experiment& e, const Plant* plant, const SymmetryConfig& symmetry) {
  if (plant == nullptr) return std::nullopt;
  const bool driven = e.known ? e.known->excitation.has_value() : e.moves_inputs();
  return symmetry_counterexample(*plant, symmetry, e.known ? e.known->simulation : e.simulation, driven);
}

void check_mirror(const Experiment& e, const Plant* plant) {
  const Refuse refuse = [](const std::string& why) { throw KeyError("training.mirror", "[training] mirror " + why); };
  const SymmetryConfig mirror = mirror_symmetry(e);
  if (mirror.channels.empty())
    refuse(
        "= true: every channel is declared even (odd = false), so a mirror image is the run itself; set mirror = "
        "false");
  if (e.log) return check_derivatives(mirror, *e.log, refuse);
  if (const auto found = counterexample(e, plant, mirror))
    refuse(fmt::format("= true: the plant is not odd: {}; {}set mirror = false", *found,
                       e.plant->even.empty() ? "name what keeps its sign in [plant] even, or " : ""));
}

}  // namespace

void check_symmetries(const Experiment& e) {
  if (!e.training.mirror && e.symmetries.empty()) return;
  const auto plant = e.plant ? make_plant(*e.plant) : e.known ? make_plant(e.known->plant) : nullptr;
  if (e.training.mirror) check_mirror(e, plant.get());
  const std::vector<Side> sides = sides_of(e, plant.get());
  for (std::size_t i = 0; i < e.symmetries.size(); ++i) {
    const SymmetryConfig& symmetry = e.symmetries[i];
    const auto refuse_at = [&](const std::string& key, const std::string& why) {
      throw KeyError(fmt::format("symmetry[{}]{}", i, key),
                     fmt::format("[[symmetry]]{}{} {}", symmetry.kind.empty() ? "" : " ", symmetry.kind, why));
    };
    const Refuse refuse = [&](const std::string& why) { refuse_at("", why); };
    check_shape(symmetry, refuse);
    check_names(symmetry, sides, refuse);
    check_vectors(symmetry, sides, refuse);
    check_moved_angles(symmetry, sides, refuse);
    if (e.log) check_derivatives(symmetry, *e.log, refuse);
    if (const auto found = counterexample(e, plant.get(), symmetry))
      refuse(fmt::format("is not a symmetry of the plant: {}; name all that it moves, or remove it", *found));
    if (!symmetry.by_construction) continue;
    const ChannelCounts channels = observer_channels(e);
    std::vector<Channel> readings = channels.output_channels;
    readings.insert(readings.end(), channels.read_input_channels.begin(), channels.read_input_channels.end());
    const std::string gap =
        structure_of(e.observer).symmetry_gap(on_channels(symmetry, readings, channels.state_channels), e, channels);
    if (!gap.empty())
      refuse_at(".by_construction", fmt::format("by_construction: {}; remove by_construction, and training turns its "
                                                "segments",
                                                gap));
  }
}

}  // namespace nlo::trainer
