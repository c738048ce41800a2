// SPDX-License-Identifier: MIT
#include "trainer/app/commands/input_facts.h"

#include <fmt/format.h>

#include <algorithm>

#include "trainer/data/log_delays.h"
#include "trainer/plants/registry.h"
#include "trainer/structures/table.h"

namespace nlo::trainer {
namespace {

constexpr const char* kFact = "ignored_inputs";

/// Before the config, which is long: a reader of model.json meets it first.
void record(codegen::Model& model, const char* name, const std::string& fact) {
  const auto config = std::ranges::find(model.provenance, "config", [](const auto& each) { return each.first; });
  model.provenance.insert(config, {name, fact});
}

}  // namespace

std::string ignored_inputs(const Experiment& experiment) {
  const TrainableStructure& structure = structure_of(experiment.observer);
  if (structure.flies_inputs() || (experiment.moves_inputs() && structure.reads_inputs())) return "";
  if (!experiment.plant) return "";
  // A built-in plant has an input whether the user wants one or not:
  // that its experiment leaves it at zero is no mistake.
  if (!experiment.plant->model.empty() && !experiment.moves_inputs()) return "";
  const auto plant = make_plant(*experiment.plant);
  std::string names;
  for (const codegen::Channel& input : plant->inputs()) names += (names.empty() ? "" : ", ") + input.name;
  return names;
}

void record_ignored_inputs(const Experiment& experiment, codegen::Model& model) {
  const std::string names = ignored_inputs(experiment);
  if (!names.empty()) record(model, kFact, names);
}

std::string ignored_inputs_note(const codegen::Model& model) {
  for (const auto& [name, inputs] : model.provenance)
    if (name == kFact)
      return fmt::format(
          "note: this {} observer was trained without inputs, so it does not know {}: where an input acts, its "
          "estimates are off; train with an [excitation], or take structure = \"driven_kkl\"\n",
          codegen::structure_name(model), inputs);
  return "";
}

void record_input_delays(const Experiment& experiment, codegen::Model& model) {
  if (!experiment.log || model.nu() == 0) return;
  const std::string delays = delays_in_flight(*experiment.log, model.sample_period_s);
  if (!delays.empty()) record(model, "input_delay", "feed u as it was so many samples ago: " + delays);
}

}  // namespace nlo::trainer
