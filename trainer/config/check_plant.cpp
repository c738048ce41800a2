// SPDX-License-Identifier: MIT
#include "trainer/config/check_plant.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>
#include <vector>

#include "trainer/base/number_text.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/registry.h"

namespace nlo::trainer {
namespace {

using Fault = std::optional<ConfigFault>;

ConfigFault fault_of(const std::string& key, const std::string& what) {
  return {"simulation." + key, fmt::format("[simulation] {}{}", key, what)};
}

Fault box_fault(const SimulationConfig& s, std::size_t nx) {
  for (const auto& [key, size] :
       {std::pair{"initial_low", s.initial_low.size()}, std::pair{"initial_high", s.initial_high.size()}}) {
    if (size == nx) continue;
    if (size == 0)
      return ConfigFault{"simulation", fmt::format("[simulation] {} is missing; give the corner of the training box, "
                                                   "{} numbers, one for each state",
                                                   key, nx)};
    return fault_of(key, fmt::format(" has {} numbers; the plant has {} states", size, nx));
  }
  for (std::size_t i = 0; i < nx; ++i)
    if (!(s.initial_low[i] <= s.initial_high[i]))
      return fault_of("initial_high", fmt::format("[{0}] is {1}; it must not be below initial_low[{0}], {2}", i,
                                                  shortest_text(s.initial_high[i]), shortest_text(s.initial_low[i])));
  return {};
}

/// Of a list of states: each with a number for each state.
Fault rows_fault(const char* key, const std::vector<std::vector<double>>& rows, std::size_t nx) {
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (rows[i].size() != nx)
      return fault_of(key, fmt::format("[{}] has {} numbers; the plant has {} states", i, rows[i].size(), nx));
  return {};
}

Fault circle_fault(const SimulationConfig& s, std::size_t nx) {
  if (!s.initial_centre.empty() && s.initial_centre.size() != nx)
    return fault_of("initial_centre",
                    fmt::format(" has {} numbers; the plant has {} states", s.initial_centre.size(), nx));
  if (s.initial_axes.size() != 2)
    return fault_of("initial_axes", fmt::format(" has {} half axes; a circle has two, each with {} numbers, such as "
                                                "[[2, 0], [0, 2]] for radius 2 in a plane",
                                                s.initial_axes.size(), nx));
  return rows_fault("initial_axes", s.initial_axes, nx);
}

Fault list_fault(const SimulationConfig& s, std::size_t nx) {
  if (s.initial_states.empty())
    return fault_of("initial_states",
                    fmt::format(" is empty; list at least one state of {} numbers: [[0.1, 0.2], ...]", nx));
  return rows_fault("initial_states", s.initial_states, nx);
}

/// An output or an estimated state that is an angle.
struct Angle {
  std::string name;
  bool sincos;
};

Angle angle_of_column(const ColumnConfig& column) {
  return {column.name, column.encoding == "sincos"};
}

/// The angles of one side of a plant; `only`: names of those that count, empty: all.
std::vector<Angle> plant_angles(const std::vector<Channel>& channels, const std::vector<std::string>& encodings,
                                const std::vector<std::string>& only = {}) {
  std::vector<Angle> angles;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const bool counts = only.empty() || std::find(only.begin(), only.end(), channels[i].name) != only.end();
    if (counts && channels[i].wrap > 0.0)
      angles.push_back({channels[i].name, !encodings.empty() && encodings[i] == "sincos"});
  }
  return angles;
}

/// When y turns by 2 pi, so does z, if its DC gain is one; then z - y never sees the turn.
Fault output_fault(const ObserverConfig& o, const std::vector<Angle>& outputs, const std::string& mend) {
  for (const auto& [name, sincos] : outputs) {
    if (sincos) continue;
    if (o.structure == "luenberger" || o.structure == "general")
      return ConfigFault{"observer.structure", fmt::format("[observer] structure = \"{}\" cannot follow the output {}, "
                                                           "an unwrapped angle; set {}",
                                                           o.structure, name, mend)};
    for (const auto& [key, is, needed] :
         {std::tuple{"features", &o.features, "latent_minus_output"},
          std::tuple{"output_injection", &o.output_injection, "unit_gain"}, std::tuple{"start", &o.start, "steady"}})
      if (*is != needed)
        return ConfigFault{fmt::format("observer.{}", key),
                           fmt::format("[observer] {} is \"{}\", but the output {} is an unwrapped angle; set {} = "
                                       "\"{}\", or {}",
                                       key, *is, name, key, needed, mend)};
  }
  return {};
}

/// T* of an unwrapped angle reads z - y, which does not know the angle itself; T(x) reads states, which must come back
/// when the plant does.
Fault plant_state_fault(const Experiment& e, const PlantChannels& channels, const std::vector<Angle>& outputs,
                        const std::vector<Angle>& states) {
  const auto unwrapped = [](const Angle& angle) { return !angle.sincos; };
  const auto output = std::find_if(outputs.begin(), outputs.end(), unwrapped);
  const auto state = std::find_if(states.begin(), states.end(), unwrapped);
  if (output != outputs.end() && state != states.end())
    return ConfigFault{
        "plant.state_wraps",
        fmt::format("[plant] the state {0} is an unwrapped angle, and so is the output {1}: T* reads z - "
                    "{1}, which is the same wherever it points, and cannot give {0} itself; leave {0} "
                    "out of `estimated`, or set state_encodings to \"sincos\" for it",
                    state->name, output->name)};
  if (!e.uses_forward_map()) return {};
  if (!channels.all_states())
    return ConfigFault{"plant.estimated",
                       "[plant] estimated leaves out states, and T(x) is a function of all of them; remove it, or the "
                       "losses of T and structure = \"driven_kkl\""};
  if (output != outputs.end() || state != states.end())
    return ConfigFault{
        output != outputs.end() ? "plant.output_wraps" : "plant.state_wraps",
        fmt::format("[plant] {} is an unwrapped angle, and T(x) must come back when the plant does; set its encoding "
                    "to \"sincos\", or remove the losses of T",
                    output != outputs.end() ? output->name : state->name)};
  if (e.observer.structure == "driven_kkl" && !channels.plain())
    return ConfigFault{"plant",
                       "[plant] a driven observer carries the input field of the plant's own states: sine, cosine and "
                       "another order in `estimated` are not for it; remove them, or take structure = \"kkl\""};
  return {};
}

Fault mirror_fault(const Experiment& e, const std::vector<Angle>& outputs, const std::vector<Angle>& states) {
  if (!e.training.mirror) return {};
  for (const auto* angles : {&outputs, &states})
    for (const auto& [name, sincos] : *angles)
      if (sincos)
        return ConfigFault{"training.mirror",
                           fmt::format("[training] mirror turns every sign, and cos({}) has none to turn; set mirror = "
                                       "false, or the angle's encoding = \"unwrap\"",
                                       name)};
  return {};
}

}  // namespace

std::optional<ConfigFault> initial_state_fault(const SimulationConfig& s, std::size_t nx) {
  const std::string& kind = s.initial_distribution;
  const bool box = kind == "uniform" || kind == "gaussian";
  struct Given {
    const char* key;
    bool is_given, belongs;
  };
  for (const auto& [key, is_given, belongs] :
       {Given{"initial_low", !s.initial_low.empty(), box}, Given{"initial_high", !s.initial_high.empty(), box},
        Given{"initial_centre", !s.initial_centre.empty(), kind == "circle"},
        Given{"initial_axes", !s.initial_axes.empty(), kind == "circle"},
        Given{"initial_states", !s.initial_states.empty(), kind == "list"}})
    if (is_given && !belongs)
      return fault_of(key, fmt::format(" has no use for initial_distribution = \"{}\"; remove one of them", kind));
  if (kind == "circle") return circle_fault(s, nx);
  if (kind == "list") return list_fault(s, nx);
  return box_fault(s, nx);
}

std::optional<ConfigFault> angle_fault(const Experiment& e) {
  std::vector<Angle> outputs, states;
  if (e.log) {
    for (const ColumnConfig& column : e.log->columns) {
      if (column.wrap == 0.0) continue;
      if (column.role == ColumnRole::kOutput) outputs.push_back(angle_of_column(column));
      if (column.role == ColumnRole::kState) states.push_back(angle_of_column(column));
    }
    if (const Fault fault = output_fault(e.observer, outputs, "its encoding = \"sincos\"")) return fault;
  } else {
    const auto plant = make_plant(*e.plant);
    outputs = plant_angles(plant->outputs(), e.plant->output_encodings);
    states = plant_angles(plant->states(), e.plant->state_encodings, e.plant->estimated);
    if (const Fault fault = output_fault(e.observer, outputs, "its [plant] output_encodings to \"sincos\""))
      return fault;
    if (const Fault fault = plant_state_fault(e, PlantChannels(*e.plant, *plant), outputs, states)) return fault;
  }
  return mirror_fault(e, outputs, states);
}

}  // namespace nlo::trainer
