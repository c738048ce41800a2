// SPDX-License-Identifier: MIT
#include "trainer/commands/log_columns.h"

#include <algorithm>

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

}  // namespace

LogConfig columns_for(const codegen::Model& model, const Experiment& experiment, const std::string& file) {
  LogConfig log;
  if (!file.empty()) {
    log = read_log_columns(file);
  } else if (experiment.log) {
    return *experiment.log;
  } else {
    log.columns.push_back(column_of({"time", "s", 0.0}, ColumnRole::kTime));
    for (const codegen::Channel& output : model.outputs) log.columns.push_back(column_of(output, ColumnRole::kOutput));
    for (const codegen::Channel& input : model.inputs) log.columns.push_back(column_of(input, ColumnRole::kInput));
    for (const codegen::Channel& state : model.states) log.columns.push_back(column_of(state, ColumnRole::kState));
  }
  const bool timed = std::any_of(log.columns.begin(), log.columns.end(),
                                 [](const ColumnConfig& column) { return column.role == ColumnRole::kTime; });
  if (!timed && log.sample_period_s == 0.0) log.sample_period_s = model.sample_period_s;
  return log;
}

}  // namespace nlo::trainer
