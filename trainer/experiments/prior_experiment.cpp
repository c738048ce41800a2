// SPDX-License-Identifier: MIT
#include "trainer/experiments/prior_experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <vector>

#include "codegen/base/error.h"
#include "trainer/base/number_text.h"
#include "trainer/data/log_column.h"
#include "trainer/data/log_dataset.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/structures/known_equations.h"
#include "trainer/structures/structure.h"

namespace nlo::trainer {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

[[noreturn]] void no_prior(const std::string& why) {
  throw codegen::Error(why);
}

const ColumnConfig* find_column(const LogConfig& log, ColumnRole role, const std::string& name) {
  const auto found = std::ranges::find_if(
      log.columns, [&](const ColumnConfig& column) { return column.role == role && column.name == name; });
  return found == log.columns.end() ? nullptr : &*found;
}

/// Encodes an angle as its sine and cosine. Refuses an angle in another unit than radians.
void encode(ColumnConfig& column) {
  if (column.wrap == 0.0) return;
  if (column.wrap != kTurn)
    no_prior(
        fmt::format("the wrap of \"{}\" is {}, but a prior needs angles in radians: convert the column to rad by its "
                    "unit and file_unit, and write the equations for rad",
                    column.name, shortest_text(column.wrap)));
  column.encoding = Encoding::kSincos;
}

/// Makes the columns of the prior: the outputs and the states in the order of the plant.
class Columns {
 public:
  explicit Columns(const Identification& identification) : plant_(identification.plant), log_(identification.log) {
    for (const ColumnConfig& column : log_.columns)
      if (column.role == ColumnRole::kTime || column.role == ColumnRole::kMask) all_.push_back(column);
    for (const std::string& output : plant_.output_names) add_output(output);
    for (const ColumnConfig& column : log_.columns)
      if (column.role == ColumnRole::kInput) all_.push_back(column);
    for (const std::string& state : plant_.states) add_state(state);
    if (estimated_.empty())
      no_prior("the logs have a column for none of the states of the plant, but a prior needs the truth of one");
    // A velocity may be computed from a column that is not a channel here.
    for (const ColumnConfig& column : log_.columns)
      if (column.role == ColumnRole::kIgnored || is_left_out(column)) {
        all_.push_back(column);
        all_.back().role = ColumnRole::kIgnored;
        all_.back().period_s = 0.0;
      }
  }

  const std::vector<ColumnConfig>& all() const { return all_; }
  /// Fills the names, units, wraps and encodings of the plant's channels, and the states that have a column if some do
  /// not.
  void describe(PlantConfig& plant) const {
    const auto add = [](const ColumnConfig& column, std::vector<std::string>& units, std::vector<double>& wraps,
                        std::vector<Encoding>& encodings) {
      units.push_back(column.unit);
      wraps.push_back(column.wrap);
      encodings.push_back(column.encoding);
    };
    plant.output_names.clear();
    const auto column_of = [this](const std::string& state) {
      const auto found = std::ranges::find_if(all_, [&state](const ColumnConfig& column) {
        return column.role == ColumnRole::kState && column.name == state;
      });
      return found == all_.end() ? ColumnConfig{} : *found;
    };
    for (const std::string& state : plant.states)
      add(column_of(state), plant.state_units, plant.state_wraps, plant.state_encodings);
    for (const ColumnConfig& column : all_) {
      if (column.role != ColumnRole::kOutput) continue;
      add(column, plant.output_units, plant.output_wraps, plant.output_encodings);
      plant.output_names.push_back(column.name);
    }
    if (estimated_.size() < plant.states.size()) plant.estimated = estimated_;
    for (const std::string& input : plant.inputs) plant.input_units.push_back(unit_of_input(input));
  }

 private:
  static bool has(const std::vector<std::string>& names, const std::string& name) {
    return std::ranges::find(names, name) != names.end();
  }

  /// Returns true for an output of the logs that the plant does not have.
  bool is_left_out(const ColumnConfig& column) const {
    return column.role == ColumnRole::kOutput && column.expression.empty() && !has(plant_.output_names, column.name);
  }

  void add_output(const std::string& name) {
    ColumnConfig column = *find_column(log_, ColumnRole::kOutput, name);
    if (!column.expression.empty())
      no_prior(
          fmt::format("the output \"{}\" is computed from other columns, but a prior needs measured outputs", name));
    if (has(plant_.states, name)) {
      column.column = heading_of(column);
      column.name += "_measured";
    }
    encode(column);
    all_.push_back(column);
  }

  void add_state(const std::string& name) {
    const ColumnConfig* column = find_column(log_, ColumnRole::kState, name);
    if (column == nullptr) column = measured(name);
    if (column == nullptr) return;
    estimated_.push_back(name);
    ColumnConfig state = *column;
    state.column = heading_of(*column);
    if (state.column == name) state.column.clear();
    state.name = name;
    state.role = ColumnRole::kState;
    state.period_s = 0.0;
    if (state.derivative_of.empty()) encode(state);
    all_.push_back(state);
  }

  /// Returns the output column that measures the state itself.
  const ColumnConfig* measured(const std::string& state) const {
    for (std::size_t j = 0; j < plant_.outputs.size(); ++j) {
      std::string text = plant_.outputs[j];
      std::erase(text, ' ');
      if (text == state) return find_column(log_, ColumnRole::kOutput, plant_.output_names[j]);
    }
    return nullptr;
  }

  std::string unit_of_input(const std::string& name) const { return find_column(log_, ColumnRole::kInput, name)->unit; }

  const PlantConfig& plant_;
  const LogConfig& log_;
  std::vector<ColumnConfig> all_;
  std::vector<std::string> estimated_;  ///< states that have a column
};

/// Returns the plant with these values of its parameters.
PlantConfig identified_plant(const PlantConfig& plant, const Eigen::VectorXd& parameters) {
  PlantConfig result = plant;
  result.parameter_ranges.clear();
  for (std::size_t i = 0; i < result.parameters.size(); ++i)
    result.parameters[i].second = parameters[static_cast<Eigen::Index>(i)];
  return result;
}

/// Refuses equations that a prior cannot step, each with its own reason.
void check_equations(const PlantConfig& plant, const LogConfig& log) {
  std::vector<std::string> inputs;
  for (const ColumnConfig& column : log.columns)
    if (column.role == ColumnRole::kInput) inputs.push_back(column.name);
  const KnownEquations known = known_equations(plant, true, inputs);
  codegen::Equations(known.texts, known.states, known.inputs);
}

}  // namespace

std::string prior_experiment(const Identification& identification, const Eigen::VectorXd& parameters,
                             const std::string& directory) {
  const IdentifyConfig& identify = identification.identify;
  Experiment e;
  e.name = identification.name + "_prior";
  e.log = identification.log;
  e.evaluation = identification.evaluation;
  KnownPlant& known = e.known.emplace();
  known.plant = identified_plant(identification.plant, parameters);
  const Columns columns(identification);
  columns.describe(known.plant);
  e.log->columns = columns.all();
  check_equations(known.plant, *e.log);

  known.simulation.share = 0.0;  // the equations only step the observer
  if (e.log->sample_period_s > 0.0) known.simulation.sample_period_s = e.log->sample_period_s;
  for (std::size_t i = 0; i < identify.initial_state.size(); ++i) {
    known.simulation.initial_low.push_back(identify.initial_state[i] - identify.initial_deviation[i]);
    known.simulation.initial_high.push_back(identify.initial_state[i] + identify.initial_deviation[i]);
  }
  e.observer.structure = "prior";
  e.observer.input_hold = identify.input_hold;
  const std::string text = format_draft(e);
  check_start(parse_draft(text, "the experiment").experiment, load_logs(*e.log, directory, e.log->train_files));
  return text;
}

}  // namespace nlo::trainer
