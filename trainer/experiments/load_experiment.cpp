// SPDX-License-Identifier: MIT
#include "trainer/experiments/load_experiment.h"

#include <fmt/format.h>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "trainer/config/toml.h"
#include "trainer/config/value.h"
#include "trainer/experiments/check.h"
#include "trainer/experiments/section_tables.h"

namespace nlo::trainer {

Experiment parse_experiment(std::string_view text, const std::string& filename,
                            const std::vector<std::string>& overrides) {
  Toml root = parse_toml(text, filename);
  for (const std::string& assignment : overrides) apply_override(root, assignment);

  Places places(filename);
  SectionTables reader(filename, places);
  Experiment experiment;
  reader.read(root, "", experiment,
              {"plant", "simulation", "excitation", "feedback", "log", "observer", "dynamics", "inverse_map",
               "forward_map", "loss", "training", "evaluation"});
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
  reader.read_if_there(root, "evaluation", experiment.evaluation);
  check_experiment(experiment, places);
  experiment.source_text = format_experiment(experiment);
  return experiment;
}

Experiment read_experiment(const std::string& path, const std::vector<std::string>& overrides) {
  return parse_experiment(codegen::read_file(path, kMaxConfigBytes), path, overrides);
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
