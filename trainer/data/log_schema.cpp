// SPDX-License-Identifier: MIT
#include "trainer/data/log_schema.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string_view>

#include "codegen/base/error.h"
#include "codegen/model/computed_outputs.h"
#include "trainer/config/key_error.h"
#include "trainer/data/units.h"

namespace nlo::trainer {
namespace {

using codegen::Channel;

double seconds_per_unit(const ColumnConfig& column, const std::vector<ColumnConfig>& all) {
  if (column.unit.empty()) return 1.0;
  if (const Unit* unit = find_unit(column.unit); unit != nullptr && unit->kind == "time") return unit->scale;
  fail_at(column, all, fmt::format("unit \"{}\" of the time column: expected s, ms, us, ns, min or h", column.unit));
}

/// Checks a `column` with an expression: it must not have keys for cells.
void check_computed(const ColumnConfig& column, const std::vector<ColumnConfig>& all) {
  if (column.role != ColumnRole::kOutput)
    fail_at(column, all,
            "expression is only for columns with role \"output\", which the observer computes from its measurements: "
            "remove it, or change the role");
  const char* other = heading_of(column) != column.name ? "column"
                      : !column.derivative_of.empty()   ? "derivative_of"
                      : !column.file_unit.empty()       ? "file_unit"
                      : column.scale != 1.0             ? "scale"
                      : column.offset != 0.0            ? "offset"
                      : column.wrap != 0.0              ? "wrap"
                      : !column.missing.empty()         ? "missing"
                      : column.delay_s != 0.0           ? "delay_s"
                      : column.period_s != 0.0          ? "period_s"
                                                        : nullptr;
  if (other != nullptr)
    fail_at(column, all,
            fmt::format("{} describes a column of the file, but this column is computed by an expression: remove {}, "
                        "or the expression",
                        other, other));
}

/// Appends the computed outputs behind the measured ones.
void append_computed(const LogConfig& config, LogSchema& schema) {
  const std::size_t measured = schema.output_channels.size();
  std::vector<const ColumnConfig*> columns;
  for (const ColumnConfig& column : config.columns) {
    if (column.expression.empty()) continue;
    check_computed(column, config.columns);
    columns.push_back(&column);
    schema.output_channels.push_back({column.name, column.unit, 0.0, column.expression});
    try {
      codegen::ComputedOutputs(schema.output_channels, schema.input_channels);
    } catch (const codegen::Error& error) {
      fail_at(column, config.columns, error.what());
    }
  }
  if (measured == 0 && !columns.empty())
    fail_at(*columns.front(), config.columns, "all outputs are computed, but at least one must be measured: list one");
}

void append_channels(const LogColumn& column, std::vector<Channel>& channels) {
  if (column.sincos) {
    channels.push_back({column.name + "_sin", "", 0.0, "", column.period_s});
    channels.push_back({column.name + "_cos", "", 0.0, "", column.period_s});
  } else {
    channels.push_back({column.name, column.unit, column.derivative ? 0.0 : column.wrap, "", column.period_s});
  }
}

/// Returns the channels of the outputs that measure the quantity of `state`, in its unit, if there are any.
StateSource measured_by(const LogColumn& state, const std::vector<LogColumn>& outputs) {
  int channel = 0;
  for (const LogColumn& output : outputs) {
    if (output.heading == state.heading && output.scale == state.scale && output.offset == state.offset &&
        state.rate == 1.0)
      return {StateKind::kMeasured, channel, output.sincos ? channel + 1 : -1, output.wrap};
    channel += output.channels();
  }
  return {};
}

void append_sources(const LogColumn& state, const std::vector<LogColumn>& outputs, std::vector<StateSource>& sources) {
  StateSource source = measured_by(state, outputs);
  const auto append = [&](StateKind kind) {
    if (source.kind != StateKind::kHidden) source.kind = kind;
    sources.push_back(source);
  };
  if (state.sincos) append(StateKind::kSineOfMeasured);
  append(state.sincos       ? StateKind::kCosineOfMeasured
         : state.derivative ? StateKind::kDerivativeOfMeasured
                            : StateKind::kMeasured);
}

/// Returns the key of the last column with that name; the section if a channel has the name of no column: "angle_sin".
std::string key_of(const std::string& name, const std::vector<ColumnConfig>& all) {
  for (std::size_t i = all.size(); i-- > 0;)
    if (all[i].name == name) return fmt::format("log.columns[{}]", i);
  return "log";
}

void check_names(const LogSchema& schema, const std::vector<ColumnConfig>& all) {
  std::set<std::string> taken;
  for (const auto* channels : {&schema.output_channels, &schema.state_channels, &schema.input_channels})
    for (const Channel& channel : *channels)
      if (!taken.insert(channel.name).second)
        throw KeyError(key_of(channel.name, all),
                       fmt::format("[[log.columns]] \"{}\": the name is used twice: if a column is both output and "
                                   "state, list it twice, with two names and the same `column`",
                                   channel.name));
}

}  // namespace

CsvFormat format_of(const LogConfig& config) {
  if (config.separator == "," && config.decimal == ",")
    throw KeyError("log.decimal",
                   "[log] decimal = \",\", but a comma also separates the cells: set separator, which is \";\" in most "
                   "logs with decimal commas");
  const char separator = config.separator == "tab" ? '\t' : config.separator == "space" ? ' ' : config.separator[0];
  return {separator, config.decimal[0]};
}

LogSchema resolve_columns(const LogConfig& config) {
  LogSchema schema;
  schema.format = format_of(config);
  schema.missing = config.missing;
  for (const ColumnConfig& column : config.columns) {
    if (!column.expression.empty()) continue;
    const LogColumn resolved = resolve_column(column, config.columns);
    switch (column.role) {
      case ColumnRole::kTime:
        if (!schema.time_heading.empty())
          fail_at(column, config.columns, "a second column with role \"time\": expected one");
        schema.time_heading = resolved.heading;
        schema.time_unit_s = seconds_per_unit(column, config.columns);
        schema.has_time_unit = !column.unit.empty();
        break;
      case ColumnRole::kOutput:
        schema.outputs.push_back(resolved);
        append_channels(resolved, schema.output_channels);
        break;
      case ColumnRole::kState:
        schema.states.push_back(resolved);
        append_channels(resolved, schema.state_channels);
        if (resolved.sincos)
          schema.angle_pairs.push_back(
              {resolved.name, resolved.unit, resolved.wrap, static_cast<int>(schema.state_channels.size()) - 2});
        break;
      case ColumnRole::kInput:
        if (resolved.wrap > 0.0)
          fail_at(column, config.columns, "an input cannot be an angle, because inputs are not unwrapped: remove wrap");
        schema.inputs.push_back(resolved);
        append_channels(resolved, schema.input_channels);
        break;
      case ColumnRole::kMask:
        schema.masks.push_back(resolved);
        break;
      case ColumnRole::kIgnored:
        break;
    }
  }
  append_computed(config, schema);
  if (schema.outputs.empty())
    throw KeyError("log",
                   "[[log.columns]]: no column has role \"output\": list the columns that the observer measures");
  if (schema.states.empty())
    throw KeyError("log",
                   "[[log.columns]]: no column has role \"state\": list the columns that the observer estimates");
  if (schema.time_heading.empty() && !(config.sample_period_s > 0.0))
    throw KeyError("log", "[log]: no column has role \"time\" and sample_period_s is not given: expected one of them");
  for (const LogColumn& state : schema.states) append_sources(state, schema.outputs, schema.state_sources);
  check_names(schema, config.columns);
  return schema;
}

}  // namespace nlo::trainer
