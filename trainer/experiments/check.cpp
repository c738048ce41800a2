// SPDX-License-Identifier: MIT
#include "trainer/experiments/check.h"

#include <fmt/format.h>

#include "trainer/base/number_text.h"
#include "trainer/config/key_error.h"
#include "trainer/config/keys.h"
#include "trainer/data/log_schema.h"
#include "trainer/experiments/checks.h"
#include "trainer/experiments/observer_channels.h"
#include "trainer/structures/table.h"

namespace nlo::trainer {
namespace {

void check_sources(const Experiment& e, const Places& places) {
  if (e.name.empty()) throw KeyError("", "the experiment has no name; begin the file with name = \"my_observer\"");
  if (!e.plant && !e.log)
    throw KeyError("", "neither [plant] nor [log]; say what to learn from: a plant to simulate, or logs");
  if (e.plant && e.log) throw KeyError("log", "both [plant] and [log]; keep one: a plant to simulate, or logs");
  if (e.log && e.excitation) throw KeyError("excitation", "[excitation] has no use for [log]; remove it");
  if (e.log && e.feedback)
    throw KeyError("feedback", "[feedback] simulates a loop, and logs are as they were recorded; remove it");
  if (e.log && places.has("simulation")) throw KeyError("simulation", "[simulation] has no use for [log]; remove it");
}

void check_log(const Experiment& e) {
  const LogConfig& log = *e.log;
  if (log.columns.empty())
    throw KeyError("log", "[log] has no columns; name them: [[log.columns]] with name = \"...\" and role = \"...\"");
  for (std::size_t i = 0; i < log.columns.size(); ++i)
    if (log.columns[i].name.empty())
      throw KeyError(fmt::format("log.columns[{}]", i), "[[log.columns]] has no name; give one: name = \"...\"");
  if (log.train_files.empty())
    throw KeyError("log",
                   "[log] has no train_files; list the logs to train on: train_files = [\"run1.csv\", \"day2/*.csv\"]");
  resolve_columns(log);
}

/// A key of another structure has no use here: it was meant for that one.
void check_observer(const Experiment& e) {
  const ObserverConfig& o = e.observer;
  const TrainableStructure& structure = structure_of(o);
  for (const TrainableStructure* other : structure_table()) {
    if (other == &structure) continue;
    for (const Key<ObserverConfig>& key : other->own_keys())
      if (!has_key(structure.own_keys(), key.name) && key.show(o) != key.show(ObserverConfig{}))
        throw KeyError(fmt::format("observer.{}", key.name),
                       fmt::format("[observer] {} belongs to structure = \"{}\"; this one is \"{}\"", key.name,
                                   other->name(), structure.name()));
  }
  const ChannelCounts channels = observer_channels(e);
  if (channels.read_inputs > 0 && o.input_hold == Hold::kFirstOrder && o.hold == Hold::kZeroOrder)
    throw KeyError(
        "observer.input_hold",
        "[observer] input_hold is \"first_order\", and hold \"zero_order\": inputs run as the outputs do, or "
        "are commands; set hold = \"first_order\", or input_hold = \"zero_order\"");
  structure.check(e, channels);
}

void check_evaluation(const Experiment& e) {
  const auto& windows = e.evaluation.windows;
  const auto refuse = [&](const EvaluationWindow& window, const std::string& what) {
    throw KeyError("evaluation.windows", fmt::format("[evaluation] window \"{}\" {}", window.name, what));
  };
  for (std::size_t i = 0; i < windows.size(); ++i) {
    const EvaluationWindow& window = windows[i];
    if (window.name == "all") refuse(window, "is the whole run, which is always told; give it another name");
    for (std::size_t j = 0; j < i; ++j)
      if (windows[j].name == window.name) refuse(window, "stands there twice; give one of them another name");
    if (!(window.from_s < window.to_s))
      refuse(window, fmt::format("runs from {} s to {} s; from_s must be the smaller one", shortest_text(window.from_s),
                                 shortest_text(window.to_s)));
  }
}

}  // namespace

void check_experiment(const Experiment& e, const Places& places) try {
  check_sources(e, places);
  if (e.plant) check_plant_and_simulation(e);
  if (e.plant) check_excitation(e);
  if (e.log) check_log(e);
  check_observer(e);
  if (e.plant) check_feedback(e);
  check_angles(e);
  check_losses(e);
  check_training(e);
  check_transient(e);
  check_evaluation(e);
} catch (const KeyError& error) {
  throw codegen::Error(fmt::format("{}: {}", places.of(error.key()), error.what()));
}

}  // namespace nlo::trainer
