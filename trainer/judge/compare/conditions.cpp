// SPDX-License-Identifier: MIT
#include "trainer/judge/compare/conditions.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "trainer/base/nearest_name.h"
#include "trainer/base/number_text.h"
#include "trainer/config/section_reader.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/judge/compare/default_conditions.h"

namespace nlo::trainer {
namespace {

using Parameters = std::vector<std::pair<std::string, double>>;

const std::vector<Key<Condition>>& condition_keys() {
  static const std::vector<Key<Condition>> kKeys = {
      key("name", &Condition::name, identifiers(), "name in tables and in JSON"),
      key("noise", &Condition::noise, any(), "noise of the outputs; see nlo evaluate --noise"),
      key("parameter_factor", &Condition::parameter_factor, positive(),
          "factor for one parameter in each run; successive runs change successive parameters"),
      {"parameters", "{ NAME = number, ... }",
       "changed parameters of the plant; filters and observers know the nominal values",
       [](Condition& condition, const Toml& value, const std::string& where) {
         std::vector<std::pair<std::string, std::array<double, 2>>> ranges;
         read_parameters(value, where, condition.parameters, ranges);
         if (!ranges.empty())
           throw codegen::Error(
               fmt::format("{}: {}.{} is a range, but a condition needs one value: write parameters = {{ {} = {} }}",
                           place_of(value), where, ranges.front().first, ranges.front().first,
                           shortest_text(ranges.front().second[1])));
       },
       [](const Condition& condition) { return show_parameters(condition.parameters, {}); }},
      key("process_noise", &Condition::process_noise, at_least(0),
          "standard deviation of white noise on dx/dt per sqrt(s), one for each state or one for all"),
      key("box_scale", &Condition::box_scale, positive(), "factor for the size of the training box of initial states"),
      key("set", &Condition::changes, any(),
          "changes of keys of [plant], [simulation], [excitation] or [feedback], each as KEY=VALUE"),
      key("input", &Condition::inputs, any(), "u(t) of each input, instead of [excitation]"),
      key("input_noise", &Condition::input_noise, any(), "noise of the inputs that estimators read"),
  };
  return kKeys;
}

const std::vector<Key<ConditionSet>>& set_keys() {
  static const std::vector<Key<ConditionSet>> kKeys = {
      key("written_for_deviation", &ConditionSet::written_for_deviation, at_least(0),
          "standard deviation of outputs and states for which the numbers of the conditions were chosen"),
      key("written_for_noise", &ConditionSet::written_for_noise, at_least(0),
          "standard deviation of the sensors' noise in training for which the noises of the conditions were chosen"),
  };
  return kKeys;
}

std::string no_home(const std::string& name) {
  for (const auto& known : condition_keys())
    if (known.name == name) return "[[condition]]";
  for (const auto& known : set_keys())
    if (known.name == name) return "the top of the file";
  return "";
}

[[noreturn]] void fail(const Condition& condition, const std::string& what) {
  throw codegen::Error(fmt::format("{}: condition \"{}\" {}", condition.place, condition.name, what));
}

/// Scales noise. Outliers and clipping scale with the output, other noise with the noise of its sensor.
void scale_noise(NoiseConfig& noise, const ChannelScales& scales, const ConditionSet& set) {
  std::vector<SensorNoise> sensors;
  for (Eigen::Index j = 0; j < scales.outputs.size(); ++j) {
    SensorNoise& own = sensors.emplace_back(noise.of(static_cast<std::size_t>(j)));
    const double by_output = round_factor(scales.outputs[j] / set.written_for_deviation);
    const bool has_noise = set.written_for_noise > 0.0 && scales.noise[j] > 0.0;
    const double by_noise = has_noise ? round_factor(scales.noise[j] / set.written_for_noise) : by_output;
    for (double* number : {&own.outlier_amplitude, &own.limit}) *number *= by_output;
    for (double* number : {&own.scale, &own.bias, &own.common_bias, &own.quantum}) *number *= by_noise;
  }
  if (std::adjacent_find(sensors.begin(), sensors.end(), std::not_equal_to<>()) == sensors.end()) sensors.resize(1);
  noise.sensors = std::move(sensors);
}

void check(const Condition& condition, const Parameters& nominal, const Eigen::VectorXd& outputs,
           const Eigen::VectorXd& states) {
  try {
    check_noise(condition.noise, static_cast<std::size_t>(outputs.size()));
  } catch (const codegen::Error& error) {
    fail(condition, fmt::format("has a noise that does not fit: {}", error.what()));
  }
  std::vector<std::string> known;
  for (const auto& entry : nominal) known.push_back(entry.first);
  for (const auto& entry : condition.parameters) {
    const std::string& name = entry.first;
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    const std::string nearest = nearest_name(name, known);
    fail(condition, fmt::format("changes the parameter \"{}\", which the plant does not have; {}", name,
                                known.empty()     ? "it has none"
                                : nearest.empty() ? fmt::format("there are: {}", fmt::join(known, ", "))
                                                  : fmt::format("did you mean \"{}\"?", nearest)));
  }
  const auto given = static_cast<Eigen::Index>(condition.process_noise.size());
  if (given > 1 && given != states.size())
    fail(condition, fmt::format("has process_noise for {} states, but the plant has {} states; give one number for "
                                "each state, or one for all",
                                given, states.size()));
}

}  // namespace

ConditionSet parse_conditions(std::string_view text, const std::string& filename) {
  constexpr std::size_t kMost = 200;
  const Toml root = parse_toml(text, filename);
  Places places(filename);
  SectionReader reader(filename, places, no_home);
  ConditionSet set;
  reader.read(root, "", "a file of conditions", set_keys(), set, {"condition"});
  const auto tables = root.as_table().find("condition");
  if (tables == root.as_table().end())
    throw codegen::Error(fmt::format(
        "{}: there is no condition; write a table [[condition]] with name and noise for each condition", filename));
  const std::string where = "[[condition]]";
  for (const Toml& table : list_of(tables->second, where, {.at_most = kMost})) {
    if (!table.is_table())
      throw codegen::Error(
          fmt::format("{}: condition is {}, but it must be a table: write [[condition]] with name and noise below it",
                      reader.place(table), type_in_words(table)));
    Condition condition;
    condition.place = reader.place(table);
    reader.read(table, fmt::format("condition[{}]", set.conditions.size()), where, condition_keys(), condition);
    if (condition.name.empty())
      throw codegen::Error(
          fmt::format("{}: a condition has no name; begin it with name = \"heavy_tails\"", condition.place));
    for (const Condition& before : set.conditions)
      if (before.name == condition.name)
        fail(condition, fmt::format("is given twice, first in {}; rename one", before.place));
    set.conditions.push_back(std::move(condition));
  }
  if (set.conditions.empty())
    throw codegen::Error(
        fmt::format("{}: there is no condition; write [[condition]] with name and noise below it", filename));
  return set;
}

ConditionSet read_conditions(const std::string& path) {
  return parse_conditions(codegen::read_file(path, kMaxConfigBytes), path);
}

const ConditionSet& default_conditions() {
  static const ConditionSet kSet = parse_conditions(kDefaultConditions, "conditions.toml");
  return kSet;
}

double round_factor(double factor) {
  if (!(factor > 0.0) || !std::isfinite(factor)) return 1.0;
  const double decade = std::pow(10.0, std::floor(std::log10(factor)));
  double best = decade;
  for (const double round : {2.0, 5.0, 10.0})
    if (std::abs(std::log(factor / (round * decade))) < std::abs(std::log(factor / best))) best = round * decade;
  return best;
}

std::vector<Condition> conditions_of(const ConditionSet& set, const Parameters& parameters, const ChannelScales& scales,
                                     std::vector<std::string>& left_out) {
  const Eigen::VectorXd &outputs = scales.outputs, &states = scales.states;
  const double written_for = set.written_for_deviation;
  std::vector<Condition> result;
  for (Condition condition : set.conditions) {
    if (condition.parameter_factor != 1.0 && parameters.empty()) {
      if (written_for == 0.0) fail(condition, "has a parameter_factor, but the plant has no parameters; remove it");
      left_out.push_back(condition.name);
      continue;
    }
    check(condition, parameters, outputs, states);
    std::vector<double>& process = condition.process_noise;
    if (process.size() == 1) process.assign(static_cast<std::size_t>(states.size()), process.front());
    if (written_for > 0.0) {
      scale_noise(condition.noise, scales, set);
      for (std::size_t i = 0; i < process.size(); ++i)
        process[i] *= round_factor(states[static_cast<Eigen::Index>(i)] / written_for);
    }
    result.push_back(std::move(condition));
  }
  return result;
}

Parameters changed_parameters(const Condition& condition, const Parameters& nominal, std::size_t run) {
  Parameters result = nominal;
  if (!result.empty()) result[run % result.size()].second *= condition.parameter_factor;
  for (auto& [name, value] : result)
    for (const auto& [own, given] : condition.parameters)
      if (own == name) value = given;
  return result;
}

std::string condition_title(const Condition& condition) {
  std::string title = noise_title(condition.noise);
  if (condition.parameter_factor != 1.0) title += ", a parameter x " + shortest_text(condition.parameter_factor);
  for (const auto& [name, value] : condition.parameters) title += fmt::format(", {} = {}", name, shortest_text(value));
  std::string process;
  for (const double value : condition.process_noise) process += (process.empty() ? "" : ", ") + shortest_text(value);
  if (!process.empty()) title += ", process noise " + process;
  if (condition.box_scale != 1.0) title += fmt::format(", {} x the box", shortest_text(condition.box_scale));
  for (const std::string& change : condition.changes) title += ", " + change;
  for (const std::string& input : condition.inputs) title += ", u = " + input;
  if (!condition.input_noise.none()) title += ", inputs read with " + noise_title(condition.input_noise);
  return title;
}

}  // namespace nlo::trainer
