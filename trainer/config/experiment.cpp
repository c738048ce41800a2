// SPDX-License-Identifier: MIT
// TOML to Experiment and back, by the table in config/keys.cpp.
#include "trainer/config/experiment.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "codegen/error.h"
#include "codegen/file.h"
#include "trainer/base/nearest_name.h"
#include "trainer/config/check.h"
#include "trainer/config/keys.h"
#include "trainer/config/toml.h"
#include "trainer/config/value.h"

namespace nlo::trainer {
namespace {

constexpr std::size_t kMostMembers = 100;  // of one table: far more than there are keys, few enough to search through

template <class Section>
std::vector<std::string> key_names() {
  std::vector<std::string> names;
  for (const auto& key : keys<Section>()) names.push_back(key.name);
  return names;
}

/// The section that knows a key, for one that stands in the wrong place.
std::string home_of(const std::string& name) {
  std::string home;
  const auto look = [&]<class Section>(const Section&) {
    const auto names = key_names<Section>();
    if (home.empty() && std::find(names.begin(), names.end(), name) != names.end()) home = section_title<Section>();
  };
  look(TrainingConfig{});
  look(EvaluationConfig{});
  look(ObserverConfig{});
  look(DynamicsConfig{});
  look(InverseMapConfig{});
  look(ForwardMapConfig{});
  look(LossConfig{});
  look(SimulationConfig{});
  look(PlantConfig{});
  look(LogConfig{});
  look(ColumnConfig{});
  look(VelocityFilterConfig{});
  look(Experiment{});
  return home;
}

class Reader {
 public:
  Reader(std::string filename, Places& places) : filename_(std::move(filename)), places_(places) {}

  /// Reads the keys of one section. `path` is "observer"; what is in `subsections` is left to the caller.
  template <class Section>
  void read(const Toml& table, const std::string& path, Section& section,
            const std::vector<std::string>& subsections = {}) {
    note(path, table);
    if (table.as_table().size() > kMostMembers)
      throw codegen::Error(fmt::format("{}: {} has {} keys; {} are the most", places_.of(path),
                                       section_title<Section>(), table.as_table().size(), kMostMembers));
    for (const auto& [name, value] : members_in_order(table)) {
      const std::string member = path.empty() ? name : path + "." + name;
      note(member, *value);
      if (std::find(subsections.begin(), subsections.end(), name) != subsections.end()) continue;
      const auto& known = keys<Section>();
      const auto key = std::find_if(known.begin(), known.end(), [&, n = name](const auto& k) { return k.name == n; });
      if (key == known.end()) unknown_key<Section>(name, member, subsections);
      key->read(section, *value, path.empty() ? name : fmt::format("{} {}", section_title<Section>(), name));
    }
  }

  /// The table of a section, or nothing when the file has none.
  const Toml* section(const Toml& parent, const std::string& path, const std::string& name) const {
    const auto found = parent.as_table().find(name);
    if (found == parent.as_table().end()) return nullptr;
    if (!found->second.is_table())
      throw codegen::Error(fmt::format("{}: {} is {}; it must be a section: [{}] with keys below it",
                                       place(found->second), path, type_in_words(found->second), path));
    return &found->second;
  }

  std::string place(const Toml& value) const {
    const std::string place = place_of(value);
    return place.starts_with("unknown file") ? filename_ : place;  // a section that only --set made
  }

  void note(const std::string& path, const Toml& value) { places_.note(path, place(value)); }

 private:
  template <class Section>
  [[noreturn]] void unknown_key(const std::string& name, const std::string& member,
                                const std::vector<std::string>& subsections) const {
    std::vector<std::string> known = key_names<Section>();
    known.insert(known.end(), subsections.begin(), subsections.end());
    const std::string nearest = nearest_name(name, known), home = home_of(name);
    std::string advice;
    if (!home.empty()) {
      advice = fmt::format("it belongs in {}", home);
    } else if (!nearest.empty()) {
      advice = fmt::format("did you mean \"{}\"?", nearest);
    } else {
      advice = fmt::format("there are: {}", fmt::join(known, ", "));
    }
    throw codegen::Error(fmt::format("{}: unknown key {} in {}; {}", places_.of(member), toml_text(name),
                                     section_title<Section>(), advice));
  }

  std::string filename_;
  Places& places_;
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

template <class Section>
std::string format_keys(const Section& section, std::string_view heading) {
  std::string text = heading.empty() ? "" : fmt::format("\n{}\n", heading);
  for (const auto& key : keys<Section>()) {
    const std::string value = key.show(section);
    const bool is_empty = value == "\"\"" || value == "[]" || value == "{}";
    if (is_empty && value == key.show(Section{})) continue;  // as good as not there, and no valid value for some
    text += fmt::format("{} = {}\n", key.name, value);
  }
  return text;
}

template <class Section>
std::string describe_keys() {
  std::string text = fmt::format("{}\n", section_title<Section>());
  for (const auto& key : keys<Section>()) {
    const std::string value = key.show(Section{});
    const bool required = value == "\"\"" || value == "[]" || value == "{}";
    text += fmt::format("  {:<25}{}\n{:27}{}{}\n", key.name, key.meaning, "", key.type,
                        required ? "" : fmt::format("; default {}", value));
  }
  return text + "\n";
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
              {"plant", "simulation", "log", "observer", "dynamics", "inverse_map", "forward_map", "loss", "training",
               "evaluation"});
  if (const Toml* table = reader.section(root, "plant", "plant"))
    reader.read(*table, "plant", experiment.plant.emplace());
  if (const Toml* table = reader.section(root, "simulation", "simulation"))
    reader.read(*table, "simulation", experiment.simulation);
  if (const Toml* table = reader.section(root, "log", "log")) experiment.log = read_log(reader, *table);
  if (const Toml* table = reader.section(root, "observer", "observer"))
    reader.read(*table, "observer", experiment.observer);
  if (const Toml* table = reader.section(root, "dynamics", "dynamics"))
    reader.read(*table, "dynamics", experiment.dynamics);
  if (const Toml* table = reader.section(root, "inverse_map", "inverse_map"))
    reader.read(*table, "inverse_map", experiment.inverse_map);
  if (const Toml* table = reader.section(root, "forward_map", "forward_map"))
    reader.read(*table, "forward_map", experiment.forward_map);
  if (const Toml* table = reader.section(root, "loss", "loss")) reader.read(*table, "loss", experiment.loss);
  if (const Toml* table = reader.section(root, "training", "training"))
    reader.read(*table, "training", experiment.training);
  if (const Toml* table = reader.section(root, "evaluation", "evaluation"))
    reader.read(*table, "evaluation", experiment.evaluation);
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

std::string format_experiment(const Experiment& experiment) {
  Experiment head = experiment;
  head.threads = 0;
  std::string text = format_keys(head, "");
  const auto threads = text.find("threads = 0\n");
  text.erase(threads, std::string_view("threads = 0\n").size());
  if (experiment.plant) {
    text += format_keys(*experiment.plant, "[plant]");
    text += format_keys(experiment.simulation, "[simulation]");
  }
  if (experiment.log) {
    text += format_keys(*experiment.log, "[log]");
    text += format_keys(experiment.log->velocity_filter, "[log.velocity_filter]");
    for (const ColumnConfig& column : experiment.log->columns) text += format_keys(column, "[[log.columns]]");
  }
  text += format_keys(experiment.observer, "[observer]");
  if (experiment.uses_dynamics_network()) text += format_keys(experiment.dynamics, "[dynamics]");
  if (experiment.uses_inverse_map()) text += format_keys(experiment.inverse_map, "[inverse_map]");
  if (experiment.uses_forward_map()) text += format_keys(experiment.forward_map, "[forward_map]");
  text += format_keys(experiment.loss, "[loss]");
  text += format_keys(experiment.training, "[training]");
  if (const EvaluationConfig& evaluation = experiment.evaluation;
      !evaluation.windows.empty() || evaluation.settling_window_s > 0.0)
    text += format_keys(evaluation, "[evaluation]");
  return text;
}

std::string describe_experiment_keys() {
  return describe_keys<Experiment>() + describe_keys<PlantConfig>() + describe_keys<SimulationConfig>() +
         describe_keys<LogConfig>() + describe_keys<VelocityFilterConfig>() + describe_keys<ColumnConfig>() +
         describe_keys<ObserverConfig>() + describe_keys<DynamicsConfig>() + describe_keys<InverseMapConfig>() +
         describe_keys<ForwardMapConfig>() + describe_keys<LossConfig>() + describe_keys<TrainingConfig>() +
         describe_keys<EvaluationConfig>();
}

}  // namespace nlo::trainer
