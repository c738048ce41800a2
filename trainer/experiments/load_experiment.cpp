// SPDX-License-Identifier: MIT
#include "trainer/experiments/load_experiment.h"

#include <fmt/format.h>

#include <algorithm>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "trainer/config/section_reader.h"
#include "trainer/config/toml.h"
#include "trainer/config/value.h"
#include "trainer/experiments/check.h"
#include "trainer/experiments/keys.h"

namespace nlo::trainer {
namespace {

std::string home_of(const std::string& name) {
  std::string home;
  for_each_section([&]<class Section>(const Section&) {
    const auto& known = keys<Section>();
    const bool knows = std::any_of(known.begin(), known.end(), [&](const auto& key) { return key.name == name; });
    if (home.empty() && knows) home = section_title<Section>();
  });
  return home;
}

/// Reads sections by the tables of keys.h.
class Reader : public SectionReader {
 public:
  Reader(const std::string& filename, Places& places) : SectionReader(filename, places, home_of) {}

  template <class Section>
  void read(const Toml& table, const std::string& path, Section& section,
            const std::vector<std::string>& subsections = {}) {
    SectionReader::read(table, path, section_title<Section>(), keys<Section>(), section, subsections);
  }

  /// A section at the top of the file; what it has not stays as it is.
  template <class Section>
  void read_if_there(const Toml& root, const std::string& name, Section& section) {
    if (const Toml* table = this->section(root, name, name)) read(*table, name, section);
  }
};

LogConfig read_log(Reader& reader, const Toml& table) {
  LogConfig log;
  reader.read(table, "log", log, {"columns", "velocity_filter"});
  if (const Toml* filter = reader.section(table, "log.velocity_filter", "velocity_filter"))
    reader.read(*filter, "log.velocity_filter", log.velocity_filter);
  const auto columns = table.as_table().find("columns");
  if (columns == table.as_table().end()) return log;
  const std::string where = "[[log.columns]]";
  for (const Toml& column : list_of(columns->second, where, any())) {
    if (!column.is_table())
      throw codegen::Error(fmt::format("{}: {} is {}; each column is a table: {} with name, role, ... below it",
                                       reader.place(column), where, type_in_words(column), where));
    ColumnConfig& config = log.columns.emplace_back();
    reader.read(column, fmt::format("log.columns[{}]", log.columns.size() - 1), config);
    if (config.column.empty() && config.derivative_of.empty()) config.column = config.name;
  }
  return log;
}

}  // namespace

Experiment parse_experiment(std::string_view text, const std::string& filename,
                            const std::vector<std::string>& overrides) {
  Toml root = parse_toml(text, filename);
  for (const std::string& assignment : overrides) apply_override(root, assignment);

  Places places(filename);
  Reader reader(filename, places);
  Experiment experiment;
  reader.read(root, "", experiment,
              {"plant", "simulation", "excitation", "log", "observer", "dynamics", "inverse_map", "forward_map", "loss",
               "training", "evaluation"});
  if (const Toml* table = reader.section(root, "plant", "plant"))
    reader.read(*table, "plant", experiment.plant.emplace());
  reader.read_if_there(root, "simulation", experiment.simulation);
  if (const Toml* table = reader.section(root, "excitation", "excitation"))
    reader.read(*table, "excitation", experiment.excitation.emplace());
  if (const Toml* table = reader.section(root, "log", "log")) experiment.log = read_log(reader, *table);
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
  Reader reader(path, places);
  for (const auto& [name, value] : members_in_order(root))
    if (name != "log")
      throw codegen::Error(fmt::format("{}: {} has no use in a table of columns; it holds [[log.columns]] alone",
                                       reader.place(*value), toml_text(name)));
  const Toml* table = reader.section(root, "log", "log");
  if (table == nullptr)
    throw codegen::Error(
        fmt::format("{}: no [[log.columns]]; name the columns of the logs, each with name and role", path));
  return read_log(reader, *table);
}

}  // namespace nlo::trainer
