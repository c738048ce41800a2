// SPDX-License-Identifier: MIT
#include "trainer/plants/equations_of_plant.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "codegen/base/error.h"
#include "trainer/plants/plant_registry.h"

namespace nlo::trainer {
namespace {

struct BuiltinEquations {
  std::string_view model;
  std::array<std::string_view, 2> derivative;
  bool driven;
};
constexpr std::array kBuiltin = {
    BuiltinEquations{"van_der_pol", {"x2", "mu * (1 - x1^2) * x2 - x1 + u"}, true},
    BuiltinEquations{"reverse_duffing", {"x2^3", "-x1 + u"}, true},
    BuiltinEquations{"sine_cosine", {"x2 + sin(x1)", "-x1 + cos(x2)"}, false},
    BuiltinEquations{"harmonic_oscillator", {"x2", "-omega^2 * x1 + u"}, true},
};

}  // namespace

PlantConfig equations_of(const PlantConfig& plant) {
  if (plant.model.empty()) return plant;
  const auto own =
      std::find_if(kBuiltin.begin(), kBuiltin.end(), [&](const auto& e) { return e.model == plant.model; });
  const auto entry = std::find_if(plant_registry().begin(), plant_registry().end(),
                                  [&](const PlantEntry& e) { return e.name == plant.model; });
  if (own == kBuiltin.end() || entry == plant_registry().end())
    throw codegen::Error("plant " + plant.model +
                         " has no equations as text; add them to plants/equations_of_plant.cpp");
  PlantConfig result = plant;
  result.model.clear();
  result.states = {"x1", "x2"};
  result.derivative = {std::string(own->derivative[0]), std::string(own->derivative[1])};
  result.output_names = {"y"};
  result.outputs = {"x1"};
  if (own->driven) result.inputs = {"u"};
  result.parameters = entry->parameters;
  for (const auto& given : plant.parameters)
    std::ranges::find(result.parameters, given.first, &PlantParameters::value_type::first)->second = given.second;
  return result;
}

}  // namespace nlo::trainer
