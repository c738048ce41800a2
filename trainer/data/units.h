// SPDX-License-Identifier: MIT
// The units of log columns and model channels, one row each, and conversions between units of one kind:
//   value in the kind's base unit = scale * value + offset
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace nlo::trainer {

struct Unit {
  std::string_view name;  ///< spelling: "m/s^2", "m/s2"; several rows may have the same meaning
  std::string_view kind;  ///< "length", "speed", "temperature", ...
  double scale = 1.0;
  double offset = 0.0;  ///< for temperatures: 0 degC is 273.15 K
};

std::span<const Unit> unit_table();

/// Returns true if `unit` is "deg" or the degree sign.
bool is_degrees(std::string_view unit);

/// Returns null if the table does not have the name. Upper and lower case differ (mPa, MPa).
const Unit* find_unit(std::string_view name);

/// value in the second unit = scale * value in the first + offset
struct Conversion {
  double scale = 1.0, offset = 0.0;

  double operator()(double value) const { return scale * value + offset; }
};

/// Returns the conversion between two units of the same kind, rows of the table; exactly 1 and 0 if they are the same.
Conversion conversion(const Unit& from, const Unit& to);

/// Returns the kind of the rate of change: "speed" for "length"; empty if the table has none.
std::string_view kind_of_rate(std::string_view kind);

/// Relation of two texts as units.
enum class UnitsAre { kTheSame, kConvertible, kOfDifferentKinds, kUnknown };

/// Compares units. kTheSame: equal texts, or one is empty (unknown), or rows with equal numbers. `conversion` is set
/// for kTheSame and kConvertible.
UnitsAre compare_units(std::string_view from, std::string_view to, Conversion& conversion);

/// Returns "\"deg\" (angle)", or "\"foo\"" if the table does not have the unit.
std::string with_kind(std::string_view unit);

}  // namespace nlo::trainer
