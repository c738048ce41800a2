// SPDX-License-Identifier: MIT
#include "trainer/experiments/load_experiment.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "trainer/config/toml.h"
#include "trainer/config/value.h"
#include "trainer/experiments/check.h"
#include "trainer/experiments/section_tables.h"

namespace nlo::trainer {
namespace {

/// A KKL observer without eigenvalues is left to a recipe;
/// other structures have defaults that suit no plant in particular.
bool is_draft(const Experiment& experiment, const Places& places) {
  return experiment.observer.structure == ObserverConfig{}.structure && experiment.observer.eigenvalues.empty() &&
         experiment.observer.pairs.empty() && !places.has("observer.eigenvalues") && !places.has("observer.pairs");
}

/// Whether an output is an angle that turns: z has to turn with it.
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

/// Sets what the checks ask of any observer of this data, where the file leaves it out.
void stand_in(Experiment& e, const Places& places) {
  constexpr double kSlow = 0.05;  // of the sample rate: stable by any hold
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
  reader.read_if_there(root, "observer", experiment.observer);
  reader.read_if_there(root, "dynamics", experiment.dynamics);
  reader.read_if_there(root, "inverse_map", experiment.inverse_map);
  reader.read_if_there(root, "forward_map", experiment.forward_map);
  reader.read_if_there(root, "loss", experiment.loss);
  reader.read_if_there(root, "training", experiment.training);
  reader.read_if_there(root, "validation", experiment.validation);
  reader.read_if_there(root, "evaluation", experiment.evaluation);
  const bool draft = is_draft(experiment, places);
  if (draft) stand_in(experiment, places);
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
  check_experiment(draft.experiment, draft.given);  // says what is missing
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
    if (name != "log")
      throw codegen::Error(fmt::format("{}: {} has no use in a table of columns; it holds [[log.columns]] alone",
                                       reader.place(*value), toml_text(name)));
  const Toml* table = reader.section(root, "log", "log");
  if (table == nullptr)
    throw codegen::Error(
        fmt::format("{}: no [[log.columns]]; name the columns of the logs, each with name and role", path));
  return read_log_section(reader, *table);
}

}  // namespace nlo::trainer
