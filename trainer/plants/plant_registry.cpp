// SPDX-License-Identifier: MIT
#include "trainer/plants/plant_registry.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "trainer/base/nearest_name.h"
#include "trainer/config/key_error.h"
#include "trainer/plants/builtin.h"
#include "trainer/plants/expression_plant.h"

namespace nlo::trainer {
namespace {

/// Returns "did you mean ...?" or the list of known names.
std::string advice(std::string_view wrong, const std::vector<std::string>& known) {
  const std::string nearest = nearest_name(wrong, known);
  if (!nearest.empty()) return fmt::format("did you mean \"{}\"?", nearest);
  return known.empty() ? "it has none" : fmt::format("there are: {}", fmt::join(known, ", "));
}

PlantParameters complete_parameters(const PlantEntry& entry, const PlantParameters& given) {
  PlantParameters parameters = entry.parameters;
  for (const auto& wanted : given) {
    const auto found = std::find_if(parameters.begin(), parameters.end(),
                                    [&](const auto& parameter) { return parameter.first == wanted.first; });
    if (found == parameters.end()) {
      std::vector<std::string> known;
      for (const auto& parameter : parameters) known.push_back(parameter.first);
      throw KeyError("plant.parameters", fmt::format("plant {} has no parameter \"{}\"; {}", entry.name, wanted.first,
                                                     advice(wanted.first, known)));
    }
    found->second = wanted.second;
  }
  return parameters;
}

}  // namespace

std::span<const PlantEntry> plant_registry() {
  static const std::array<PlantEntry, 4> kPlants = {{
      {"van_der_pol", "Van der Pol oscillator (22), y = x1, u drives x2", {{"mu", 1.0}}, make_van_der_pol},
      {"reverse_duffing", "reverse Duffing oscillator (23), y = x1, u drives x2", {}, make_reverse_duffing},
      {"sine_cosine", "example 1 of the paper (21), y = x1", {}, make_sine_cosine},
      {"harmonic_oscillator",
       "undamped linear oscillator, y = x1, u drives x2",
       {{"omega", 1.0}},
       make_harmonic_oscillator},
  }};
  return kPlants;
}

std::unique_ptr<Plant> make_plant(const PlantConfig& config) {
  if (config.model.empty()) return std::make_unique<ExpressionPlant>(config);
  if (!config.states.empty() || !config.derivative.empty() || !config.output_names.empty() || !config.outputs.empty() ||
      !config.inputs.empty() || !config.input_field.empty())
    throw KeyError("plant",
                   "[plant] has both a model and equations; keep either `model` or states, derivative, outputs");
  for (const auto& [key, wraps] :
       {std::pair{"state_wraps", &config.state_wraps}, std::pair{"output_wraps", &config.output_wraps}})
    if (!wraps->empty())
      throw KeyError(
          fmt::format("plant.{}", key),
          fmt::format("[plant] {} is for a plant given by equations; built-in plants have no angles: remove it", key));
  std::vector<std::string> known;
  for (const PlantEntry& entry : plant_registry()) {
    if (entry.name == config.model) return entry.make(complete_parameters(entry, config.parameters));
    known.emplace_back(entry.name);
  }
  throw KeyError("plant.model",
                 fmt::format("[plant] model \"{}\" is unknown; {}", config.model, advice(config.model, known)));
}

}  // namespace nlo::trainer
