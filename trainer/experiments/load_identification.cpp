// SPDX-License-Identifier: MIT
#include "trainer/experiments/load_identification.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "codegen/base/file.h"
#include "trainer/base/nearest_name.h"
#include "trainer/config/key_error.h"
#include "trainer/data/dataset.h"
#include "trainer/data/log_schema.h"
#include "trainer/experiments/identify_keys.h"
#include "trainer/experiments/section_tables.h"
#include "trainer/plants/parametric_plant.h"

namespace nlo::trainer {
namespace {

using Names = std::vector<std::string>;

bool has(const Names& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string advice(const std::string& name, const Names& known) {
  const std::string nearest = nearest_name(name, known);
  return nearest.empty() ? fmt::format("there are: {}", fmt::join(known, ", "))
                         : fmt::format("did you mean \"{}\"?", nearest);
}

void require(const Names& names, const Names& known, const std::string& key, const std::string& what,
             const std::string& where) {
  for (const std::string& name : names)
    if (!has(known, name)) throw KeyError(key, fmt::format("{} \"{}\" {}; {}", what, name, where, advice(name, known)));
}

void require_one_for_each_state(const std::vector<double>& values, const std::string& key, std::size_t states) {
  if (values.size() == states) return;
  throw KeyError(values.empty() ? "identify" : "identify." + key,
                 fmt::format("[identify] {} has {} numbers; the plant has {} states: give one for each", key,
                             values.size(), states));
}

void check_names(const Identification& i, const ParametricPlant& plant, const LogSchema& schema) {
  const Names outputs = channel_names(schema.output_channels), states = channel_names(schema.state_channels),
              inputs = channel_names(schema.input_channels);
  require(plant.outputs(), outputs, "plant.output_names", "[plant] output",
          "is not a column of the logs with role \"output\"");
  require(plant.inputs(), inputs, "plant.inputs", "[plant] input", "is not a column of the logs with role \"input\"");
  require(states, plant.states(), "log", "[[log.columns]] state",
          "is not a state of the plant, so no filter estimates it");
  Names fitted, fittable = plant.outputs();
  fittable.insert(fittable.end(), states.begin(), states.end());
  for (const auto& entry : i.identify.noise) fitted.push_back(entry.first);
  require(fitted, fittable, "identify.noise", "[identify] noise",
          "is neither an output of the plant nor a logged state");
  for (const std::string& output : plant.outputs())
    if (!has(fitted, output))
      throw KeyError("identify", fmt::format("[identify] noise does not have the output \"{}\"; give its standard "
                                             "deviation: noise = {{ {} = 0.01 }}",
                                             output, output));
  require(i.identify.fixed, plant.parameters(), "identify.fixed", "[identify] fixed",
          "is not a parameter of the plant");
  require(i.identify.positive, plant.parameters(), "identify.positive", "[identify] positive",
          "is not a parameter of the plant");
}

void check_values(const Identification& i, const ParametricPlant& plant) {
  const std::size_t nx = plant.states().size();
  require_one_for_each_state(i.identify.initial_state, "initial_state", nx);
  require_one_for_each_state(i.identify.initial_deviation, "initial_deviation", nx);
  require_one_for_each_state(i.identify.process_noise, "process_noise", nx);
  for (const auto& [name, value] : i.plant.parameters)
    if (has(i.identify.positive, name) && !(value > 0.0))
      throw KeyError("plant.parameters", fmt::format("[plant] parameters.{} is {}, and [identify] positive keeps it "
                                                     "above 0; start above",
                                                     name, value));
  for (const auto& [name, range] : i.plant.parameter_ranges)
    if (!(range[0] < range[1]))
      throw KeyError("plant.parameters",
                     fmt::format("[plant] parameters.{} = [{}, {}] is too narrow; widen it", name, range[0], range[1]));
  if (i.identify.fixed.size() >= plant.parameters().size())
    throw KeyError("identify.fixed", "[identify] fixed has all parameters; leave out those to be found");
  if (i.identify.from_s.empty()) throw KeyError("identify.from_s", "[identify] from_s is empty; write [0.0]");
}

void check(const Identification& i) {
  if (i.name.empty()) throw KeyError("", "the identification has no name; begin the file with name = \"my_rig\"");
  const ParametricPlant plant(i.plant);
  if (i.log.train_files.empty())
    throw KeyError("log", "[log] has no train_files; list the logs to identify on: train_files = [\"run1.csv\"]");
  const LogSchema schema = resolve_columns(i.log);
  if (!schema.angle_pairs.empty())
    throw KeyError("log",
                   "[[log.columns]] encoding = \"sincos\" cannot be used here, because an angle of a plant is one "
                   "state; remove it");
  check_names(i, plant, schema);
  check_values(i, plant);
}

}  // namespace

Identification parse_identification(std::string_view text, const std::string& filename,
                                    const std::vector<std::string>& overrides) {
  Toml root = parse_toml(text, filename);
  for (const std::string& assignment : overrides) apply_override(root, assignment);
  Places places(filename);
  SectionTables reader(filename, places);
  Identification result;
  reader.read(root, "", result, {"plant", "log", "identify", "evaluation"});
  for (const char* section : {"plant", "log", "identify"})
    if (!root.contains(section))
      throw codegen::Error(
          fmt::format("{}: there is no [{}]; an identification has [plant], [log] and [identify]{}", filename, section,
                      root.contains("observer") ? "; the training of an observer needs another file" : ""));
  reader.read_if_there(root, "plant", result.plant);
  if (const Toml* table = reader.section(root, "log", "log")) result.log = read_log_section(reader, *table);
  reader.read_if_there(root, "identify", result.identify);
  reader.read_if_there(root, "evaluation", result.evaluation);
  try {
    for (const char* key : {"state_wraps", "output_wraps", "state_encodings", "output_encodings", "estimated", "even"})
      if (const std::string path = std::string("plant.") + key; places.has(path))
        throw KeyError(
            path,
            fmt::format(
                "[plant] {} has no effect here, because [[log.columns]] defines outputs, states and angles: remove it",
                key));
    check(result);
  } catch (const KeyError& error) {
    throw codegen::Error(fmt::format("{}: {}", places.of(error.key()), error.what()));
  }
  return result;
}

Identification read_identification(const std::string& path, const std::vector<std::string>& overrides) {
  return parse_identification(codegen::read_file(path, kMaxConfigBytes), path, overrides);
}

}  // namespace nlo::trainer
