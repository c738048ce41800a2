// SPDX-License-Identifier: MIT
// The units that columns of logs and channels of models may have, one row each,
// and conversions between those of one kind:
//   value in the kind's base unit = scale * value + offset
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace nlo::trainer {

struct Unit {
  std::string_view name;  ///< as it is written: "m/s^2", "m/s2"; several rows may mean the same
  std::string_view kind;  ///< "length", "speed", "temperature", ...
  double scale = 1.0;
  double offset = 0.0;  ///< for temperatures: 0 degC is 273.15 K
};

std::span<const Unit> unit_table();

/// Whether `unit` is "deg" or the degree sign.
bool is_degrees(std::string_view unit);

/// Null when the table has no such name; upper and lower case differ (mPa, MPa).
const Unit* find_unit(std::string_view name);

/// value in the second unit = scale * value in the first + offset
struct Conversion {
  double scale = 1.0, offset = 0.0;

  double operator()(double value) const { return scale * value + offset; }
};

/// From one unit to another of the same kind; exactly 1 and 0 where they are the same. Both are rows of the table.
Conversion conversion(const Unit& from, const Unit& to);

/// The kind of the rate of change: "speed" of "length"; empty when the table has none.
std::string_view kind_of_rate(std::string_view kind);

/// Relation of two texts as units.
enum class UnitsAre { kTheSame, kConvertible, kOfDifferentKinds, kUnknown };

/// Compares units. kTheSame: equal texts, or one is empty (unknown), or rows with equal numbers. `conversion` is set
/// for kTheSame and kConvertible.
UnitsAre compare_units(std::string_view from, std::string_view to, Conversion& conversion);

/// "\"deg\" (angle)", or "\"foo\"" when the table has no such unit.
std::string with_kind(std::string_view unit);

}  // namespace nlo::trainer
