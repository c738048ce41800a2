// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "trainer/config/key_error.h"
#include "trainer/experiments/experiment_checks.h"
#include "trainer/experiments/observer_channels.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/structures/structure_table.h"

namespace nlo::trainer {
namespace {

/// An output or an estimated state that is an angle.
struct Angle {
  std::string name;
  bool sincos;
};

Angle angle_of_column(const ColumnConfig& column) {
  return {column.name, column.encoding == Encoding::kSincos};
}

/// Returns the angles among the outputs or the states of a plant. If `only` is not empty, only those named in it count.
std::vector<Angle> plant_angles(const std::vector<Channel>& channels, const std::vector<Encoding>& encodings,
                                const std::vector<std::string>& only = {}) {
  std::vector<Angle> angles;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const bool counts = only.empty() || std::find(only.begin(), only.end(), channels[i].name) != only.end();
    if (counts && channels[i].wrap > 0.0)
      angles.push_back({channels[i].name, !encodings.empty() && encodings[i] == Encoding::kSincos});
  }
  return angles;
}

/// If y increases by 2 pi, z must also increase by 2 pi, so that z - y does not change. This needs a DC gain of one.
void check_outputs(const ObserverConfig& o, const std::vector<Angle>& outputs, const std::string& mend) {
  for (const auto& [name, sincos] : outputs) {
    if (sincos) continue;
    if (!structure_of(o).follows_unwrapped_angles())
      throw KeyError("observer.structure", fmt::format("[observer] structure = \"{}\" cannot follow the output {}, "
                                                       "an unwrapped angle; set {}",
                                                       o.structure, name, mend));
    const auto require = [&, output = name](const char* key, auto is, auto needed) {
      if (is == needed) return;
      throw KeyError(fmt::format("observer.{}", key),
                     fmt::format("[observer] {} is \"{}\", but the output {} is an unwrapped angle; set {} = \"{}\", "
                                 "or {}",
                                 key, to_name(is), output, key, to_name(needed), mend));
    };
    require("features", o.features, FeatureSet::kLatentMinusOutput);
    require("output_injection", o.output_injection, Injection::kUnitGain);
    require("start", o.start, LatentStart::kSteady);
  }
}

/// For an unwrapped angle, T* reads z - y, from which the angle itself cannot be computed. T(x) needs states that have
/// the same values whenever the plant is in the same position.
void check_plant_states(const Experiment& e, const PlantChannels& channels, const std::vector<Angle>& outputs,
                        const std::vector<Angle>& states) {
  const auto unwrapped = [](const Angle& angle) { return !angle.sincos; };
  const auto output = std::find_if(outputs.begin(), outputs.end(), unwrapped);
  const auto state = std::find_if(states.begin(), states.end(), unwrapped);
  if (output != outputs.end() && state != states.end())
    throw KeyError("plant.state_wraps",
                   fmt::format("[plant] the state {0} is an unwrapped angle, and so is the output {1}: T* only reads z "
                               "- {1}, which does not depend on the angle itself, so it cannot estimate {0}; leave {0} "
                               "out of `estimated`, or set its state_encodings to \"sincos\"",
                               state->name, output->name));
  if (!uses_forward_map(e)) return;
  if (!channels.all_states())
    throw KeyError("plant.estimated",
                   "[plant] estimated leaves out states, but T(x) is a function of all states; remove it, or remove "
                   "the losses of T and structure = \"driven_kkl\"");
  if (output != outputs.end() || state != states.end())
    throw KeyError(output != outputs.end() ? "plant.output_wraps" : "plant.state_wraps",
                   fmt::format("[plant] {} is an unwrapped angle, but T(x) must have the same value after a full turn; "
                               "set its encoding to \"sincos\", or remove the losses of T",
                               output != outputs.end() ? output->name : state->name));
  if (structure_of(e.observer).flies_inputs() && !channels.plain())
    throw KeyError("plant",
                   "[plant] a driven observer needs the plant's own states in their order, because it contains their "
                   "input field; remove sine and cosine and `estimated`, or use structure = \"kkl\"");
}

}  // namespace

void check_angles(const Experiment& e) {
  std::vector<Angle> outputs, states;
  if (e.log) {
    for (const ColumnConfig& column : e.log->columns) {
      if (column.wrap == 0.0) continue;
      if (column.role == ColumnRole::kOutput) outputs.push_back(angle_of_column(column));
      if (column.role == ColumnRole::kState) states.push_back(angle_of_column(column));
    }
    check_outputs(e.observer, outputs, "its encoding = \"sincos\"");
  } else {
    const auto plant = make_plant(*e.plant);
    outputs = plant_angles(plant->outputs(), e.plant->output_encodings);
    states = plant_angles(plant->states(), e.plant->state_encodings, e.plant->estimated);
    check_outputs(e.observer, outputs, "its [plant] output_encodings to \"sincos\"");
    check_plant_states(e, PlantChannels(*e.plant, *plant), outputs, states);
  }
}

}  // namespace nlo::trainer
