// SPDX-License-Identifier: MIT
// Writes an experiment as text: as its record in a model, and as the help on its keys.
#include <fmt/format.h>

#include "trainer/experiments/identify_keys.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/load_identification.h"
#include "trainer/experiments/observer_channels.h"
#include "trainer/experiments/section_keys.h"
#include "trainer/structures/structure_table.h"

namespace nlo::trainer {
namespace {

template <class Section>
std::string format_keys(const Section& section, std::string_view heading) {
  std::string text = heading.empty() ? "" : fmt::format("\n{}\n", heading);
  for (const auto& key : keys<Section>()) {
    const std::string value = key.show(section);
    if ((key.only_when_given || is_empty_value(value)) && value == key.show(Section{}))
      continue;  // an empty value is the same as a missing key, and some keys do not accept it
    text += fmt::format("{} = {}\n", key.name, value);
  }
  return text;
}

template <class Section>
std::string describe_keys() {
  std::string text = fmt::format("{}\n", section_title<Section>());
  for (const auto& key : keys<Section>()) {
    const std::string value = key.show(Section{});
    text += fmt::format("  {:<25}{}\n{:27}{}{}\n", key.name, key.meaning, "", key.type,
                        is_empty_value(value) ? "" : fmt::format("; default {}", value));
  }
  return text + "\n";
}

/// Returns the keys without a section, and the sections of the plant and the logs.
std::string format_data(const Experiment& experiment) {
  Experiment head = experiment;
  head.threads = 0;
  std::string text = format_keys(head, "");
  const auto threads = text.find("threads = 0\n");
  text.erase(threads, std::string_view("threads = 0\n").size());
  if (experiment.plant) {
    text += format_keys(*experiment.plant, "[plant]");
    text += format_keys(experiment.simulation, "[simulation]");
    if (experiment.excitation) text += format_keys(*experiment.excitation, "[excitation]");
    if (experiment.feedback) text += format_keys(*experiment.feedback, "[feedback]");
  }
  if (const auto& known = experiment.known) {
    text += format_keys(known->plant, "[plant]");
    text += format_keys(known->simulation, "[simulation]");
    if (known->excitation) text += format_keys(*known->excitation, "[excitation]");
  }
  if (experiment.log) {
    text += format_keys(*experiment.log, "[log]");
    text += format_keys(experiment.log->velocity_filter, "[log.velocity_filter]");
    for (const ColumnConfig& column : experiment.log->columns) text += format_keys(column, "[[log.columns]]");
  }
  return text;
}

std::string format_judging(const Experiment& experiment) {
  std::string text;
  if (const ValidationConfig& validation = experiment.validation;
      experiment.log && (!validation.groups.empty() || validation.folds != ValidationConfig{}.folds))
    text += format_keys(validation, "[validation]");
  if (const EvaluationConfig& evaluation = experiment.evaluation;
      !evaluation.windows.empty() || evaluation.settling_window_s > 0.0)
    text += format_keys(evaluation, "[evaluation]");
  return text;
}

}  // namespace

std::string format_experiment(const Experiment& experiment) {
  std::string text = format_data(experiment);
  const TrainableStructure& structure = structure_of(experiment.observer);
  text += format_keys(experiment.observer, "[observer]");
  if (structure.has_dynamics_network()) text += format_keys(experiment.dynamics, "[dynamics]");
  if (structure.has_inverse_map()) text += format_keys(experiment.inverse_map, "[inverse_map]");
  if (uses_forward_map(experiment)) text += format_keys(experiment.forward_map, "[forward_map]");
  text += format_keys(experiment.loss, "[loss]");
  text += format_keys(experiment.training, "[training]");
  return text + format_judging(experiment);
}

std::string format_draft(const Experiment& experiment) {
  const ObserverConfig& o = experiment.observer;
  std::string text = format_data(experiment) + fmt::format("\n[observer]\nstructure = \"{}\"\n", o.structure);
  if (o.input_hold != ObserverConfig{}.input_hold) text += fmt::format("input_hold = \"{}\"\n", to_name(o.input_hold));
  return text + format_judging(experiment);
}

std::string describe_experiment_keys() {
  std::string text;
  for_each_section([&]<class Section>(const Section&) { text += describe_keys<Section>(); });
  return text;
}

std::string describe_identify_keys() {
  return describe_keys<IdentifyConfig>();
}

}  // namespace nlo::trainer
