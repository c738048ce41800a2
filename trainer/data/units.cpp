// SPDX-License-Identifier: MIT
#include "trainer/data/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <utility>

namespace nlo::trainer {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kGravity = 9.80665;  // standard, m/s^2
constexpr double kInch = 0.0254, kFoot = 0.3048, kMile = 1609.344, kNauticalMile = 1852.0;
constexpr double kPound = 0.45359237;

// Ambiguous names are left out: "C" (coulomb, Celsius), "mg" (milligram, a thousandth of g), "F" (farad, Fahrenheit)
// ...
constexpr Unit kUnits[] = {
    {"1", "ratio"},
    {"%", "ratio", 1e-2},
    {"percent", "ratio", 1e-2},
    {"ppm", "ratio", 1e-6},

    {"s", "time"},
    {"ms", "time", 1e-3},
    {"us", "time", 1e-6},
    {"\u00b5s", "time", 1e-6},
    {"\u03bcs", "time", 1e-6},
    {"ns", "time", 1e-9},
    {"min", "time", 60.0},
    {"h", "time", 3600.0},

    {"Hz", "frequency"},
    {"1/s", "frequency"},
    {"mHz", "frequency", 1e-3},
    {"kHz", "frequency", 1e3},
    {"MHz", "frequency", 1e6},
    {"1/min", "frequency", 1.0 / 60.0},

    {"m", "length"},
    {"nm", "length", 1e-9},
    {"um", "length", 1e-6},
    {"\u00b5m", "length", 1e-6},
    {"\u03bcm", "length", 1e-6},
    {"mm", "length", 1e-3},
    {"cm", "length", 1e-2},
    {"dm", "length", 1e-1},
    {"km", "length", 1e3},
    {"in", "length", kInch},
    {"ft", "length", kFoot},
    {"mi", "length", kMile},
    {"nmi", "length", kNauticalMile},

    {"m/s", "speed"},
    {"um/s", "speed", 1e-6},
    {"mm/s", "speed", 1e-3},
    {"cm/s", "speed", 1e-2},
    {"km/s", "speed", 1e3},
    {"km/h", "speed", 1.0 / 3.6},
    {"kph", "speed", 1.0 / 3.6},
    {"ft/s", "speed", kFoot},
    {"ft/min", "speed", kFoot / 60.0},
    {"in/s", "speed", kInch},
    {"mph", "speed", kMile / 3600.0},
    {"mi/h", "speed", kMile / 3600.0},
    {"kn", "speed", kNauticalMile / 3600.0},
    {"kt", "speed", kNauticalMile / 3600.0},

    {"m/s^2", "acceleration"},
    {"m/s2", "acceleration"},
    {"m/s\u00b2", "acceleration"},
    {"m s^-2", "acceleration"},
    {"m/s/s", "acceleration"},
    {"mm/s^2", "acceleration", 1e-3},
    {"cm/s^2", "acceleration", 1e-2},
    {"ft/s^2", "acceleration", kFoot},
    {"g", "acceleration", kGravity},
    {"g0", "acceleration", kGravity},

    {"m/s^3", "jerk"},
    {"m/s3", "jerk"},

    {"rad", "angle"},
    {"mrad", "angle", 1e-3},
    {"urad", "angle", 1e-6},
    {"deg", "angle", kDegree},
    {"\u00b0", "angle", kDegree},
    {"degrees", "angle", kDegree},
    {"mdeg", "angle", 1e-3 * kDegree},
    {"gon", "angle", kTurn / 400.0},
    {"arcmin", "angle", kDegree / 60.0},
    {"arcsec", "angle", kDegree / 3600.0},
    {"rev", "angle", kTurn},
    {"turn", "angle", kTurn},

    {"rad/s", "angular velocity"},
    {"mrad/s", "angular velocity", 1e-3},
    {"deg/s", "angular velocity", kDegree},
    {"\u00b0/s", "angular velocity", kDegree},
    {"dps", "angular velocity", kDegree},
    {"mdeg/s", "angular velocity", 1e-3 * kDegree},
    {"deg/h", "angular velocity", kDegree / 3600.0},
    {"rpm", "angular velocity", kTurn / 60.0},
    {"rev/min", "angular velocity", kTurn / 60.0},
    {"rev/s", "angular velocity", kTurn},

    {"rad/s^2", "angular acceleration"},
    {"rad/s2", "angular acceleration"},
    {"rad/s\u00b2", "angular acceleration"},
    {"deg/s^2", "angular acceleration", kDegree},
    {"deg/s2", "angular acceleration", kDegree},

    {"kg", "mass"},
    {"gram", "mass", 1e-3},
    {"lb", "mass", kPound},

    {"N", "force"},
    {"mN", "force", 1e-3},
    {"kN", "force", 1e3},
    {"kgf", "force", kGravity},
    {"lbf", "force", kPound* kGravity},

    {"N m", "torque"},
    {"Nm", "torque"},
    {"N*m", "torque"},
    {"mN m", "torque", 1e-3},
    {"mNm", "torque", 1e-3},
    {"kN m", "torque", 1e3},
    {"kNm", "torque", 1e3},

    {"Pa", "pressure"},
    {"hPa", "pressure", 1e2},
    {"kPa", "pressure", 1e3},
    {"MPa", "pressure", 1e6},
    {"mbar", "pressure", 1e2},
    {"bar", "pressure", 1e5},
    {"atm", "pressure", 101325.0},
    {"psi", "pressure", kPound* kGravity / (kInch * kInch)},
    {"mmHg", "pressure", 133.322387415},

    {"K", "temperature"},
    {"mK", "temperature", 1e-3},
    {"degC", "temperature", 1.0, 273.15},
    {"\u00b0C", "temperature", 1.0, 273.15},
    {"celsius", "temperature", 1.0, 273.15},
    {"degF", "temperature", 5.0 / 9.0, 459.67 * 5.0 / 9.0},
    {"\u00b0F", "temperature", 5.0 / 9.0, 459.67 * 5.0 / 9.0},

    {"K/s", "rate of temperature"},
    {"degC/s", "rate of temperature"},
    {"K/min", "rate of temperature", 1.0 / 60.0},
    {"degC/min", "rate of temperature", 1.0 / 60.0},

    {"V", "voltage"},
    {"uV", "voltage", 1e-6},
    {"mV", "voltage", 1e-3},
    {"kV", "voltage", 1e3},

    {"A", "current"},
    {"uA", "current", 1e-6},
    {"mA", "current", 1e-3},
    {"kA", "current", 1e3},

    {"As", "charge"},
    {"A s", "charge"},
    {"Ah", "charge", 3600.0},
    {"A h", "charge", 3600.0},
    {"mAh", "charge", 3.6},

    {"Ohm", "resistance"},
    {"ohm", "resistance"},
    {"\u03a9", "resistance"},
    {"mOhm", "resistance", 1e-3},
    {"kOhm", "resistance", 1e3},

    {"W", "power"},
    {"mW", "power", 1e-3},
    {"kW", "power", 1e3},
    {"MW", "power", 1e6},

    {"J", "energy"},
    {"mJ", "energy", 1e-3},
    {"kJ", "energy", 1e3},
    {"MJ", "energy", 1e6},
    {"Wh", "energy", 3600.0},
    {"kWh", "energy", 3.6e6},

    {"T", "magnetic flux density"},
    {"mT", "magnetic flux density", 1e-3},
    {"uT", "magnetic flux density", 1e-6},
    {"\u00b5T", "magnetic flux density", 1e-6},
    {"nT", "magnetic flux density", 1e-9},
    {"gauss", "magnetic flux density", 1e-4},

    {"Wb", "magnetic flux"},
    {"mWb", "magnetic flux", 1e-3},

    {"m^3", "volume"},
    {"m3", "volume"},
    {"L", "volume", 1e-3},
    {"l", "volume", 1e-3},
    {"mL", "volume", 1e-6},
    {"ml", "volume", 1e-6},

    {"m^3/s", "flow"},
    {"m3/s", "flow"},
    {"m^3/h", "flow", 1.0 / 3600.0},
    {"m3/h", "flow", 1.0 / 3600.0},
    {"L/s", "flow", 1e-3},
    {"l/s", "flow", 1e-3},
    {"L/min", "flow", 1e-3 / 60.0},
    {"l/min", "flow", 1e-3 / 60.0},

    {"kg/s", "mass flow"},
    {"kg/h", "mass flow", 1.0 / 3600.0},
};

constexpr std::array<std::pair<std::string_view, std::string_view>, 9> kRates = {{
    {"length", "speed"},
    {"speed", "acceleration"},
    {"acceleration", "jerk"},
    {"angle", "angular velocity"},
    {"angular velocity", "angular acceleration"},
    {"temperature", "rate of temperature"},
    {"charge", "current"},
    {"energy", "power"},
    {"volume", "flow"},
}};

}  // namespace

std::span<const Unit> unit_table() {
  return kUnits;
}

bool is_degrees(std::string_view unit) {
  return unit == "deg" || unit == "\u00b0";
}

const Unit* find_unit(std::string_view name) {
  const auto found = std::ranges::find(kUnits, name, &Unit::name);
  return found == std::end(kUnits) ? nullptr : found;
}

Conversion conversion(const Unit& from, const Unit& to) {
  if (from.scale == to.scale && from.offset == to.offset) return {};
  return {from.scale / to.scale, (from.offset - to.offset) / to.scale};
}

std::string_view kind_of_rate(std::string_view kind) {
  const auto found = std::ranges::find(kRates, kind, &std::pair<std::string_view, std::string_view>::first);
  return found == kRates.end() ? std::string_view() : found->second;
}

UnitsAre compare_units(std::string_view from, std::string_view to, Conversion& result) {
  result = {};
  if (from == to || from.empty() || to.empty()) return UnitsAre::kTheSame;
  const Unit *a = find_unit(from), *b = find_unit(to);
  if (a == nullptr || b == nullptr) return UnitsAre::kUnknown;
  if (a->kind != b->kind) return UnitsAre::kOfDifferentKinds;
  result = conversion(*a, *b);
  return result.scale == 1.0 && result.offset == 0.0 ? UnitsAre::kTheSame : UnitsAre::kConvertible;
}

std::string with_kind(std::string_view unit) {
  const Unit* known = find_unit(unit);
  return known == nullptr ? fmt::format("\"{}\"", unit) : fmt::format("\"{}\" ({})", unit, known->kind);
}

}  // namespace nlo::trainer
