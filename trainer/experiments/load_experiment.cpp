// SPDX-License-Identifier: MIT
#include "trainer/experiments/load_experiment.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "trainer/base/number_text.h"
#include "trainer/config/experiment.h"
#include "trainer/config/key_error.h"
#include "trainer/config/keys.h"
#include "trainer/config/places.h"
#include "trainer/config/toml.h"
#include "trainer/config/value.h"
#include "trainer/data/log_schema.h"
#include "trainer/experiments/experiment_checks.h"
#include "trainer/experiments/known_plant.h"
#include "trainer/experiments/observer_channels.h"
#include "trainer/experiments/section_tables.h"
#include "trainer/structures/structure_table.h"

namespace nlo::trainer {
namespace {

void check_sources(const Experiment& e, const Places& places) {
  if (e.name.empty()) throw KeyError("", "the experiment has no name; begin the file with name = \"my_observer\"");
  if (!e.plant && !e.log)
    throw KeyError("", "there is neither [plant] nor [log]; add one: a plant to simulate, or logs");
  if (e.log && e.excitation) throw KeyError("excitation", "[excitation] is not used with [log] alone; remove it");
  if (e.log && e.feedback)
    throw KeyError("feedback", "[feedback] simulates a loop, but the data are recorded logs; remove it");
  if (e.log && !e.known && places.has("simulation"))
    throw KeyError("simulation",
                   "[simulation] is not used with [log] alone; add the [plant] to simulate, or remove it");
  for (const char* key : {"noise", "share"})
    if (!e.known && places.has(fmt::format("simulation.{}", key)))
      throw KeyError(
          fmt::format("simulation.{}", key),
          fmt::format("[simulation] {} is for simulated runs with a [log]; for a plant alone set it in [training]",
                      key));
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

/// Refuses a key that belongs to another structure, because this structure would ignore it.
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
        "[observer] input_hold is \"first_order\", but hold is \"zero_order\": inputs can only be interpolated if "
        "outputs are; set hold = \"first_order\", or, for commands, input_hold = \"zero_order\"");
  structure.check(e, channels);
}

void check_evaluation(const Experiment& e) {
  const auto& windows = e.evaluation.windows;
  const auto refuse = [&](const EvaluationWindow& window, const std::string& what) {
    throw KeyError("evaluation.windows", fmt::format("[evaluation] window \"{}\" {}", window.name, what));
  };
  for (std::size_t i = 0; i < windows.size(); ++i) {
    const EvaluationWindow& window = windows[i];
    if (window.name == "all")
      refuse(window, "is the name of the whole run, which is always reported; choose another name");
    for (std::size_t j = 0; j < i; ++j)
      if (windows[j].name == window.name) refuse(window, "is listed twice; give one of them another name");
    if (!(window.from_s < window.to_s))
      refuse(window, fmt::format("runs from {} s to {} s; from_s must be the smaller one", shortest_text(window.from_s),
                                 shortest_text(window.to_s)));
  }
}

/// Throws codegen::Error `FILE:LINE: reason; remedy`.
void check_experiment(const Experiment& e, const Places& places) try {
  check_sources(e, places);
  if (e.plant) check_plant_and_simulation(e);
  if (e.plant) check_excitation(e);
  if (e.log) check_log(e);
  check_observer(e);
  if (e.known) check_known_plant(e);
  if (e.plant) check_feedback(e);
  check_angles(e);
  check_losses(e);
  check_training(e);
  check_mirror(e);
  check_transient(e);
  check_evaluation(e);
} catch (const KeyError& error) {
  throw codegen::Error(fmt::format("{}: {}", places.of(error.key()), error.what()));
}

/// Returns true for a KKL observer without eigenvalues.
bool lacks_eigenvalues(const Experiment& experiment, const Places& places) {
  return experiment.observer.structure == ObserverConfig{}.structure && experiment.observer.eigenvalues.empty() &&
         experiment.observer.pairs.empty() && !places.has("observer.eigenvalues") && !places.has("observer.pairs");
}

/// Returns true for an observer without eigenvalues whose settings a recipe can derive, and whose file does not say how
/// long to train it.
bool lacks_steps(const Experiment& experiment, const Places& places) {
  Experiment adopting = experiment;
  const TrainableStructure& structure = structure_of(experiment.observer);
  return !structure.has_eigenvalues() && !places.has("training.steps") && structure.adopt(adopting, 1.0);
}

/// Returns true if an output is an angle that turns. z must turn with it.
bool follows_an_angle(const Experiment& e) {
  const auto turns = [](double wrap, Encoding encoding) { return wrap > 0.0 && encoding == Encoding::kUnwrap; };
  if (e.log)
    return std::any_of(e.log->columns.begin(), e.log->columns.end(), [&](const ColumnConfig& column) {
      return column.role == ColumnRole::kOutput && turns(column.wrap, column.encoding);
    });
  if (!e.plant) return false;
  for (std::size_t j = 0; j < e.plant->output_wraps.size(); ++j)
    if (turns(e.plant->output_wraps[j],
              j < e.plant->output_encodings.size() ? e.plant->output_encodings[j] : Encoding::kUnwrap))
      return true;
  return false;
}

/// Sets missing keys that the checks require of any observer, so that a draft can be checked.
void stand_in(Experiment& e, const Places& places) {
  constexpr double kSlow = 0.05;  // as a share of the sample rate; stable with any hold
  const double period_s = e.plant ? e.simulation.sample_period_s : e.log ? e.log->sample_period_s : 0.0;
  e.observer.eigenvalues = {-kSlow / (period_s > 0.0 ? period_s : 1.0)};
  if (!follows_an_angle(e)) return;
  if (!places.has("observer.output_injection")) e.observer.output_injection = Injection::kUnitGain;
  if (!places.has("observer.start")) e.observer.start = LatentStart::kSteady;
  if (!places.has("observer.features")) e.observer.features = FeatureSet::kLatentMinusOutput;
}

}  // namespace

DraftExperiment parse_draft(std::string_view text, const std::string& filename,
                            const std::vector<std::string>& overrides) {
  Toml root = parse_toml(text, filename);
  for (const std::string& assignment : overrides) apply_override(root, assignment);

  Places places(filename);
  SectionTables reader(filename, places);
  Experiment experiment;
  reader.read(root, "", experiment,
              {"plant", "simulation", "excitation", "feedback", "log", "observer", "dynamics", "inverse_map",
               "forward_map", "loss", "training", "validation", "evaluation"});
  if (const Toml* table = reader.section(root, "plant", "plant"))
    reader.read(*table, "plant", experiment.plant.emplace());
  reader.read_if_there(root, "simulation", experiment.simulation);
  if (const Toml* table = reader.section(root, "excitation", "excitation"))
    reader.read(*table, "excitation", experiment.excitation.emplace());
  if (const Toml* table = reader.section(root, "feedback", "feedback"))
    reader.read(*table, "feedback", experiment.feedback.emplace());
  if (const Toml* table = reader.section(root, "log", "log")) experiment.log = read_log_section(reader, *table);
  if (experiment.plant && experiment.log) {
    SimulationConfig simulation = std::exchange(experiment.simulation, {});
    if (!places.has("simulation.sample_period_s") && experiment.log->sample_period_s > 0.0)
      simulation.sample_period_s = experiment.log->sample_period_s;
    experiment.known =
        KnownPlant{std::move(*experiment.plant), std::move(simulation), std::move(experiment.excitation)};
    experiment.plant.reset();
    experiment.excitation.reset();
  }
  reader.read_if_there(root, "observer", experiment.observer);
  reader.read_if_there(root, "dynamics", experiment.dynamics);
  reader.read_if_there(root, "inverse_map", experiment.inverse_map);
  reader.read_if_there(root, "forward_map", experiment.forward_map);
  reader.read_if_there(root, "loss", experiment.loss);
  reader.read_if_there(root, "training", experiment.training);
  reader.read_if_there(root, "validation", experiment.validation);
  reader.read_if_there(root, "evaluation", experiment.evaluation);
  const bool without_eigenvalues = lacks_eigenvalues(experiment, places);
  const bool draft = without_eigenvalues || lacks_steps(experiment, places);
  if (without_eigenvalues) stand_in(experiment, places);
  check_experiment(experiment, places);
  experiment.source_text = format_experiment(experiment);
  if (draft) experiment.source_text += fmt::format("# a draft of {}\n", fmt::join(places.paths(), " "));
  return {std::move(experiment), std::move(places), !draft};
}

DraftExperiment read_draft(const std::string& path, const std::vector<std::string>& overrides) {
  return parse_draft(codegen::read_file(path, kMaxConfigBytes), path, overrides);
}

Experiment parse_experiment(std::string_view text, const std::string& filename,
                            const std::vector<std::string>& overrides) {
  DraftExperiment draft = parse_draft(text, filename, overrides);
  if (draft.complete) return std::move(draft.experiment);
  draft.experiment.observer.eigenvalues.clear();
  check_experiment(draft.experiment, draft.given);  // without eigenvalues the error names the missing key
  draft.experiment.source_text = format_experiment(draft.experiment);
  return std::move(draft.experiment);
}

Experiment read_experiment(const std::string& path, const std::vector<std::string>& overrides) {
  return parse_experiment(codegen::read_file(path, kMaxConfigBytes), path, overrides);
}

Experiment experiment_of(const codegen::Model& model, const std::string& origin) {
  for (const auto& [key, text] : model.provenance)
    if (key == "config") return parse_experiment(text, origin + " (provenance.config)");
  throw codegen::Error(
      fmt::format("{}: has no provenance \"config\", so plant and columns are not known; train it again", origin));
}

LogConfig read_log_columns(const std::string& path) {
  const Toml root = parse_toml(codegen::read_file(path, kMaxConfigBytes), path);
  Places places(path);
  SectionTables reader(path, places);
  for (const auto& [name, value] : members_in_order(root))
    if (name != "log" && name != "name")  // `nlo new log` writes the name into its file
      throw codegen::Error(
          fmt::format("{}: {} has no use in a file of columns, which holds only [[log.columns]]; remove it",
                      reader.place(*value), toml_text(name)));
  const Toml* table = reader.section(root, "log", "log");
  if (table == nullptr)
    throw codegen::Error(
        fmt::format("{}: no [[log.columns]]; name the columns of the logs, each with name and role", path));
  return read_log_section(reader, *table);
}

}  // namespace nlo::trainer
