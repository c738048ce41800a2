// SPDX-License-Identifier: MIT
#include "trainer/data/log_column.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "trainer/base/nearest_name.h"
#include "trainer/config/key_error.h"
#include "trainer/data/units.h"

namespace nlo::trainer {
namespace {

/// Returns the conversion from cells to the unit of the column: scale and offset, then file_unit to unit.
Conversion conversion_of(const ColumnConfig& column, const std::vector<ColumnConfig>& all) {
  if (column.scale == 0.0) fail_at(column, all, "scale = 0 makes every value the same: expected another number");
  Conversion units;
  if (!column.file_unit.empty() && column.unit.empty())
    fail_at(column, all,
            fmt::format("file_unit = \"{}\" needs unit, to which it is converted: give unit too", column.file_unit));
  switch (compare_units(column.file_unit, column.unit, units)) {
    case UnitsAre::kTheSame:
    case UnitsAre::kConvertible:
      break;
    case UnitsAre::kOfDifferentKinds:
      fail_at(column, all,
              fmt::format("file_unit = {} cannot be converted to unit = {}: they measure different kinds of quantities",
                          with_kind(column.file_unit), with_kind(column.unit)));
    case UnitsAre::kUnknown:
      fail_at(column, all,
              fmt::format("file_unit = {} cannot be converted to unit = {}: the table of units does not have both; "
                          "write scale and offset instead of file_unit (value = scale * cell + offset)",
                          with_kind(column.file_unit), with_kind(column.unit)));
  }
  if (column.scale == 1.0 && column.offset == 0.0) return units;
  return {units.scale * column.scale, units(column.offset)};
}

/// Returns the factor from the velocity of `source`, in its unit per second, to the unit of `column`.
double rate_of(const ColumnConfig& column, const ColumnConfig& source, const std::vector<ColumnConfig>& all) {
  if (column.scale != 1.0 || column.offset != 0.0)
    fail_at(column, all,
            fmt::format("scale and offset are only for columns with cells: set them at \"{}\", of which this column is "
                        "the derivative",
                        source.name));
  if (!column.file_unit.empty()) return conversion_of(column, all).scale;
  const Unit *from = find_unit(source.unit), *to = find_unit(column.unit);
  if (from == nullptr || to == nullptr) return 1.0;
  const std::string_view kind = kind_of_rate(from->kind);
  if (kind.empty()) return 1.0;
  if (to->kind != kind)
    fail_at(column, all,
            fmt::format("unit = {} cannot be the unit of the derivative of \"{}\", which is in {}: expected one of {}",
                        with_kind(column.unit), source.name, with_kind(source.unit), kind));
  return from->scale == to->scale ? 1.0 : from->scale / to->scale;
}

/// Returns the listed column called `name`: by its name in the experiment, otherwise by its heading.
const ColumnConfig& derived_from(const ColumnConfig& column, const std::vector<ColumnConfig>& all) {
  const std::string& wanted = column.derivative_of;
  std::vector<std::string> names;
  for (const ColumnConfig& other : all) {
    if (other.name == wanted && other.derivative_of.empty()) return other;
    if (other.derivative_of.empty()) names.push_back(other.name);
  }
  for (const ColumnConfig& other : all)
    if (heading_of(other) == wanted && other.derivative_of.empty()) return other;
  const std::string nearest = nearest_name(wanted, names);
  fail_at(column, all,
          fmt::format("derivative_of = \"{}\" is not a listed column{} (list that column too, because its wrap must be "
                      "known; give it the role \"ignored\" if nothing else reads it)",
                      wanted, nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest)));
}

}  // namespace

void fail_at(const ColumnConfig& column, const std::vector<ColumnConfig>& all, std::string_view what) {
  throw KeyError(fmt::format("log.columns[{}]", &column - all.data()),
                 fmt::format("[[log.columns]] \"{}\": {}", column.name, what));
}

std::string heading_of(const ColumnConfig& column) {
  return column.column.empty() ? column.name : column.column;
}

LogColumn resolve_column(const ColumnConfig& column, const std::vector<ColumnConfig>& all) {
  LogColumn resolved{
      column.name, heading_of(column), column.unit, column.wrap, false, column.encoding == Encoding::kSincos};
  if (!(column.wrap >= 0.0))
    fail_at(column, all, fmt::format("wrap = {}: expected a full turn in the column's unit", column.wrap));
  if (resolved.sincos && column.wrap == 0.0)
    fail_at(column, all,
            "encoding = \"sincos\" needs the angle's wrap, its full turn: 6.283185307179586 for rad, 360 for degrees");
  if ((column.delay_s > 0.0 || column.find_delay) && column.role != ColumnRole::kInput)
    fail_at(
        column, all,
        "delay_s is only for columns with role \"input\": remove it; if a sensor is late, shift its column in the log");
  if (column.period_s > 0.0 && column.role != ColumnRole::kOutput)
    fail_at(
        column, all,
        "period_s is only for columns with role \"output\": remove it; other columns may have empty cells without it");
  resolved.delay_s = column.delay_s;
  resolved.period_s = column.period_s;
  resolved.missing = column.missing;
  if (column.role == ColumnRole::kTime && !column.missing.empty())
    fail_at(column, all,
            "missing is not needed at the time column, because wrong stamps are always left out: remove it");
  if (column.derivative_of.empty()) {
    if (column.role == ColumnRole::kTime && (column.scale != 1.0 || column.offset != 0.0 || !column.file_unit.empty()))
      fail_at(column, all, "scale, offset and file_unit are not for the time column: set its unit");
    const Conversion cells = conversion_of(column, all);
    resolved.scale = cells.scale;
    resolved.offset = cells.offset;
    return resolved;
  }

  if (column.role != ColumnRole::kState) fail_at(column, all, "derivative_of is for columns with role \"state\"");
  if (column.wrap > 0.0)
    fail_at(column, all, "a derivative does not wrap: write wrap at the column from which it is derived");
  const ColumnConfig& source = derived_from(column, all);
  const Conversion cells = conversion_of(source, all);
  resolved.scale = cells.scale;
  resolved.offset = cells.offset;
  resolved.rate = rate_of(column, source, all);
  resolved.heading = heading_of(source);
  resolved.missing.insert(resolved.missing.end(), source.missing.begin(), source.missing.end());
  resolved.wrap = source.wrap;
  resolved.derivative = true;
  return resolved;
}

}  // namespace nlo::trainer
