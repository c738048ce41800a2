// SPDX-License-Identifier: MIT
#include "trainer/app/commands/input_facts.h"

#include <fmt/format.h>

#include "trainer/data/log_delays.h"
#include "trainer/learn/training/provenance.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/structures/structure_table.h"

namespace nlo::trainer {

std::string ignored_inputs(const Experiment& experiment) {
  const TrainableStructure& structure = structure_of(experiment.observer);
  if (structure.flies_inputs() || (experiment.moves_inputs() && structure.reads_inputs())) return "";
  if (!experiment.plant) return "";
  // A built-in plant may have an input that the user does not need. Zero is a valid choice for it.
  if (!experiment.plant->model.empty() && !experiment.moves_inputs()) return "";
  const auto plant = make_plant(*experiment.plant);
  std::string names;
  for (const codegen::Channel& input : plant->inputs()) names += (names.empty() ? "" : ", ") + input.name;
  return names;
}

std::string ignored_inputs_note(const codegen::Model& model) {
  for (const auto& [name, inputs] : model.provenance)
    if (name == kIgnoredInputsFact)
      return fmt::format(
          "note: this {} observer was trained without inputs, so it does not know {}: its estimates are wrong while an "
          "input acts; train with an [excitation], or use structure = \"driven_kkl\"\n",
          codegen::structure_name(model), inputs);
  return "";
}

std::string input_delay(const LogConfig& log, double sample_period_s) {
  const std::string delays = delays_in_flight(log, sample_period_s);
  return delays.empty() ? "" : "pass delayed inputs to the step; delay in samples: " + delays;
}

}  // namespace nlo::trainer
