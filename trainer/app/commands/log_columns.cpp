// SPDX-License-Identifier: MIT
#include "trainer/app/commands/log_columns.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <utility>

#include "codegen/base/error.h"
#include "trainer/data/csv.h"
#include "trainer/data/csv_format.h"
#include "trainer/data/log_dataset.h"
#include "trainer/data/log_files.h"
#include "trainer/data/training_logs.h"
#include "trainer/data/units.h"
#include "trainer/experiments/load_experiment.h"

namespace nlo::trainer {
namespace {

ColumnConfig column_of(const codegen::Channel& channel, ColumnRole role) {
  ColumnConfig column;
  column.name = column.column = channel.name;
  column.role = role;
  column.unit = channel.unit;
  column.wrap = channel.wrap;
  return column;
}

/// Returns the headings of a log. Empty if the file does not start with a table; the log reader reports that error.
std::vector<std::string> headings_of(const std::string& path, const LogConfig& log) {
  constexpr std::size_t kBeginning = 1 << 16;
  std::ifstream file(path, std::ios::binary);
  std::string text(kBeginning, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() == kBeginning) text.resize(text.find_last_of("\r\n") + 1);
  try {
    const CsvFormat format = format_in(text, format_of(log));
    return CsvTable::parse(std::move(text), path, format).headings();
  } catch (const codegen::Error&) {
    return {};
  }
}

/// Returns true if a state has its own column and this is not among `headings`. A state that is computed from an output
/// has no column of its own; a missing output is an error.
bool is_absent(const LogConfig& log, const ColumnConfig& column, const std::vector<std::string>& headings) {
  if (column.role != ColumnRole::kState) return false;
  std::string source = column.column;
  for (const ColumnConfig& other : log.columns)
    if (!column.derivative_of.empty() && other.name == column.derivative_of) source = other.column;
  const bool is_read_anyway = std::ranges::any_of(log.columns, [&](const ColumnConfig& other) {
    return other.column == source && (other.role == ColumnRole::kOutput || other.role == ColumnRole::kInput);
  });
  return !is_read_anyway && std::ranges::find(headings, source) == headings.end();
}

const codegen::Channel* channel_of(const codegen::Model& model, const ColumnConfig& column) {
  const auto named = [&](const std::vector<codegen::Channel>& channels) -> const codegen::Channel* {
    const auto found = std::find_if(channels.begin(), channels.end(),
                                    [&](const codegen::Channel& channel) { return channel.name == column.name; });
    return found == channels.end() ? nullptr : &*found;
  };
  switch (column.role) {
    case ColumnRole::kOutput:
      return named(model.outputs);
    case ColumnRole::kState:
      return named(model.states);
    case ColumnRole::kInput:
      return named(model.inputs);
    default:
      return nullptr;
  }
}

/// Returns true if resolve_columns() can derive the unit of a velocity from the unit of its source.
bool derives_from_known_unit(const ColumnConfig& column, const LogConfig& log) {
  return std::any_of(log.columns.begin(), log.columns.end(), [&](const ColumnConfig& source) {
    const bool is_source = source.name == column.derivative_of || source.column == column.derivative_of;
    const Unit* unit = find_unit(source.unit);
    return is_source && source.derivative_of.empty() && unit != nullptr && !kind_of_rate(unit->kind).empty();
  });
}

/// Converts columns to the units of the model.
void match_units(const codegen::Model& model, const std::string& file, LogConfig& log,
                 std::vector<std::string>& notes) {
  for (ColumnConfig& column : log.columns) {
    const codegen::Channel* channel = channel_of(model, column);
    if (channel == nullptr) continue;
    Conversion units;
    switch (compare_units(column.unit, channel->unit, units)) {
      case UnitsAre::kTheSame:
        break;
      case UnitsAre::kConvertible:
        // A velocity is converted together with its source, if the table has the unit of the source.
        if (column.file_unit.empty() && !derives_from_known_unit(column, log)) column.file_unit = column.unit;
        column.unit = channel->unit;
        column.wrap *= units.scale;
        if (std::abs(column.wrap - channel->wrap) <= 1e-9 * channel->wrap) column.wrap = channel->wrap;
        notes.push_back(fmt::format("\"{}\" is converted to the unit that the model was trained with, {}", column.name,
                                    channel->unit));
        break;
      case UnitsAre::kOfDifferentKinds:
        throw codegen::Error(
            fmt::format("{}: [[log.columns]] \"{}\": its unit is {}, but the model uses {}, which measures another "
                        "kind of quantity; name the right column, or correct its unit",
                        file, column.name, with_kind(column.unit), with_kind(channel->unit)));
      case UnitsAre::kUnknown:
        notes.push_back(
            fmt::format("\"{}\" has the unit {}, but the model uses {}: the table of units does not have both, so "
                        "nothing is converted; if they differ, write scale and offset",
                        column.name, with_kind(column.unit), with_kind(channel->unit)));
        break;
    }
  }
}

/// Adds the outputs that the model computes, whatever the columns are.
void add_computed(const codegen::Model& model, LogConfig& log) {
  for (const codegen::Channel& output : model.outputs) {
    if (output.expression.empty()) continue;
    std::erase_if(log.columns, [&](const ColumnConfig& column) { return column.name == output.name; });
    log.columns.push_back(column_of(output, ColumnRole::kOutput));
    log.columns.back().expression = output.expression;
  }
}

}  // namespace

void leave_out_absent_truth(LogConfig& log, const std::vector<std::string>& files) {
  std::vector<std::string> absent;
  for (const std::string& path : expand_files("", files)) {
    const std::vector<std::string> headings = headings_of(path, log);
    if (headings.empty()) continue;
    std::vector<std::string> here;
    for (const ColumnConfig& column : log.columns)
      if (is_absent(log, column, headings)) here.push_back(column.name);
    const auto states = std::ranges::count(log.columns, ColumnRole::kState, &ColumnConfig::role);
    if (!here.empty() && static_cast<std::ptrdiff_t>(here.size()) == states)
      throw codegen::Error(
          fmt::format("{}: has no column of {}, so there is no truth for the evaluation; name the columns of the truth "
                      "with --columns FILE.toml",
                      path, fmt::join(here, ", ")));
    absent.insert(absent.end(), here.begin(), here.end());
  }
  std::erase_if(log.columns, [&](const ColumnConfig& column) {
    return column.role == ColumnRole::kState && std::ranges::find(absent, column.name) != absent.end();
  });
}

LogConfig columns_for(const codegen::Model& model, const Experiment& experiment, const std::string& file,
                      std::vector<std::string>& notes) {
  LogConfig log;
  if (!file.empty()) {
    log = read_log_columns(file);
    match_units(model, file, log, notes);
    add_computed(model, log);
  } else if (experiment.log) {
    return *experiment.log;
  } else {
    log.columns.push_back(column_of({"time", "s", 0.0}, ColumnRole::kTime));
    for (const codegen::Channel& output : codegen::measured_channels(model))
      log.columns.push_back(column_of(output, ColumnRole::kOutput));
    for (const codegen::Channel& input : model.inputs) log.columns.push_back(column_of(input, ColumnRole::kInput));
    for (const codegen::Channel& state : model.states) log.columns.push_back(column_of(state, ColumnRole::kState));
    add_computed(model, log);
  }
  const bool timed = std::any_of(log.columns.begin(), log.columns.end(),
                                 [](const ColumnConfig& column) { return column.role == ColumnRole::kTime; });
  if (!timed && log.sample_period_s == 0.0) log.sample_period_s = model.sample_period_s;
  return log;
}

std::optional<Dataset> training_logs_beside(const codegen::Model& model, const Experiment& experiment,
                                            const LogConfig& columns, const std::vector<std::string>& files) {
  const auto fact = std::ranges::find(model.provenance, kTrainingLogsFact, [](const auto& f) { return f.first; });
  if (!experiment.log || fact == model.provenance.end()) return std::nullopt;
  Dataset training;
  LogReport report;
  try {
    const std::string folder = std::filesystem::path(files.front()).parent_path().string();
    training = load_logs(columns, folder, experiment.log->train_files, &report);
  } catch (const codegen::Error&) {  // the logs are missing or changed
    return std::nullopt;
  }
  const TrainingLogs remembered = parse_training_logs(fact->second);
  for (const LogContent& content : report.contents) {
    std::vector<std::string> found;
    note_rows_of_training(remembered, {content}, found);
    if (found.empty()) return std::nullopt;
  }
  return training;
}

}  // namespace nlo::trainer
