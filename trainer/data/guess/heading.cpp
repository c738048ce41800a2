// SPDX-License-Identifier: MIT
#include "trainer/data/guess/heading.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>
#include <utility>

#include "codegen/base/identifier.h"
#include "trainer/base/trimmed.h"

namespace nlo::trainer {
namespace {

using Unit = std::pair<std::string_view, std::string_view>;  // ending of a heading, and its unit

// Longest first, so that "_m_s" is not read as seconds.
constexpr auto kSuffixes = std::to_array<Unit>({
    {"_rad_per_s", "rad/s"},
    {"_deg_per_s", "deg/s"},
    {"_m_per_s2", "m/s^2"},
    {"_m_per_s", "m/s"},
    {"_celsius", "degC"},
    {"_percent", "%"},
    {"_rad_s2", "rad/s^2"},
    {"_deg_s", "deg/s"},
    {"_rad_s", "rad/s"},
    {"_degc", "degC"},
    {"_deg_c", "degC"},
    {"_mps2", "m/s^2"},
    {"_m_s2", "m/s^2"},
    {"_mps", "m/s"},
    {"_ms2", "m/s^2"},
    {"_m_s", "m/s"},
    {"_kmh", "km/h"},
    {"_km_h", "km/h"},
    {"_kph", "km/h"},
    {"_dps", "deg/s"},
    {"_rps", "rad/s"},
    {"_rpm", "rpm"},
    {"_rad", "rad"},
    {"_deg", "deg"},
    {"_hpa", "hPa"},
    {"_kpa", "kPa"},
    {"_mbar", "mbar"},
    {"_bar", "bar"},
    {"_pa", "Pa"},
    {"_khz", "kHz"},
    {"_hz", "Hz"},
    {"_mv", "mV"},
    {"_ma", "mA"},
    {"_kw", "kW"},
    {"_ah", "Ah"},
    {"_nm", "N m"},
    {"_kg", "kg"},
    {"_pct", "%"},
    {"_km", "km"},
    {"_cm", "cm"},
    {"_mm", "mm"},
    {"_um", "um"},
    {"_ms", "ms"},
    {"_us", "us"},
    {"_ns", "ns"},
    {"_sec", "s"},
    {"_m", "m"},
    {"_s", "s"},
});

constexpr std::string_view kWhiteSpace = " \t\n\v\f\r";

constexpr auto kDoubtful =
    std::to_array<Unit>({{"_a", "A"}, {"_g", "g"}, {"_n", "N"}, {"_v", "V"}, {"_w", "W"}, {"_k", "K"}, {"_l", "l"}});

std::string lower(std::string_view text) {
  std::string result(text);
  std::ranges::transform(result, result.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

/// Returns the unit in the spelling of this program, for "°C" and the like.
std::string written(std::string unit) {
  constexpr auto kSame = std::to_array<Unit>({{"°C", "degC"},
                                              {"C", "degC"},
                                              {"celsius", "degC"},
                                              {"°", "deg"},
                                              {"°/s", "deg/s"},
                                              {"degrees", "deg"},
                                              {"radians", "rad"},
                                              {"sec", "s"},
                                              {"seconds", "s"},
                                              {"m/s2", "m/s^2"},
                                              {"m/s²", "m/s^2"},
                                              {"m/s/s", "m/s^2"},
                                              {"µs", "us"},
                                              {"volts", "V"},
                                              {"amps", "A"},
                                              {"Nm", "N m"},
                                              {"-", ""},
                                              {"1", ""}});
  for (const auto& [from, to] : kSame)
    if (unit == from) return std::string(to);
  return unit;
}

/// Removes "(m)" or "[m]" from the end of a heading. "y(2)" and "/joints/position[elbow]" end in an index and stay.
bool take_brackets(std::string& heading, std::string& unit) {
  for (const auto& [open, close] : {std::pair{'[', ']'}, std::pair{'(', ')'}}) {
    const auto from = heading.rfind(open);
    if (heading.empty() || heading.back() != close || from == std::string::npos || from == 0) continue;
    const std::string within(
        trimmed(std::string_view(heading).substr(from + 1, heading.size() - from - 2), kWhiteSpace));
    if (heading.front() == '/' || within.find_first_not_of("0123456789") == std::string::npos) return false;
    unit = written(within);
    heading = std::string(trimmed(std::string_view(heading).substr(0, from), kWhiteSpace));
    return true;
  }
  return false;
}

void take_suffix(std::string& heading, std::string& unit, const std::vector<std::string>& all) {
  const std::string low = lower(heading);
  const auto take = [&](const Unit& suffix) {
    if (!low.ends_with(suffix.first) || low.size() == suffix.first.size()) return false;
    unit = suffix.second;
    heading.resize(heading.size() - suffix.first.size());
    return true;
  };
  if (std::ranges::any_of(kSuffixes, take)) return;
  const std::string stem = low.substr(0, low.rfind('_') + 1);
  const auto like_it = std::ranges::count_if(all, [&](const std::string& h) { return lower(h).starts_with(stem); });
  if (!stem.empty() && like_it == 1) std::ranges::any_of(kDoubtful, take);
}

}  // namespace

Heading read_heading(const std::string& heading, const std::vector<std::string>& all) {
  Heading result;
  std::string rest(trimmed(heading, kWhiteSpace));
  if (!take_brackets(rest, result.unit)) take_suffix(rest, result.unit, all);
  std::string word;
  const auto end_word = [&] {
    if (!word.empty()) result.words.push_back(std::exchange(word, ""));
  };
  const auto is = [&](std::size_t at, int (*of_class)(int)) {
    return at < rest.size() && static_cast<unsigned char>(rest[at]) < 0x80 &&
           of_class(static_cast<unsigned char>(rest[at])) != 0;
  };
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const bool is_letter = is(i, std::isalnum), is_big = is_letter && is(i, std::isupper);
    const bool after_small = i > 0 && is(i - 1, std::isalnum) && !is(i - 1, std::isupper);
    // "IMUGyro": the last of several capitals begins the next word if two small letters follow it.
    const bool ends_capitals = i > 0 && is(i - 1, std::isupper) && is(i + 1, std::islower) && is(i + 2, std::islower);
    if (!is_letter || (is_big && (after_small || ends_capitals))) end_word();
    if (is_letter) word += static_cast<char>(std::tolower(static_cast<unsigned char>(rest[i])));
  }
  end_word();
  for (const std::string& each : result.words) result.name += (result.name.empty() ? "" : "_") + each;
  if (result.name.empty() || std::isdigit(static_cast<unsigned char>(result.name.front())) != 0)
    result.name = result.name.empty() ? "column" : "column_" + result.name;
  constexpr std::size_t kLongest = 63;
  if (result.name.size() > kLongest) result.name.resize(kLongest);
  while (result.name.ends_with('_')) result.name.pop_back();
  if (!codegen::is_identifier(result.name)) result.name = "log_" + result.name;
  return result;
}

TimeUnit time_unit(const Heading& heading, const ColumnNumbers& stamps) {
  static const std::array<TimeUnit, 4> kUnits = {
      {{"s", 1.0, ""}, {"ms", 1e-3, ""}, {"us", 1e-6, ""}, {"ns", 1e-9, ""}}};
  const std::string word = heading.name == "millis" || heading.name == "ms"   ? "ms"
                           : heading.name == "micros" || heading.name == "us" ? "us"
                                                                              : heading.unit;
  for (const TimeUnit& unit : kUnits)
    if (word == unit.name) return {unit.name, unit.seconds, "unit from the heading"};
  constexpr double kFewest = 1.0, kMost = 1e4;  // rows a second
  const double step = stamps.steps().median;
  const std::size_t first = stamps.is_whole() && step > 1.0 ? 1 : 0;
  for (std::size_t i = first; i < kUnits.size(); ++i) {
    const double rate = 1.0 / (step * kUnits[i].seconds);
    if (rate < kFewest || rate > kMost) continue;
    return {kUnits[i].name, kUnits[i].seconds,
            fmt::format("CHECK the unit: with steps of {:g}, the log has {:g} rows per second in {}", step, rate,
                        kUnits[i].name)};
  }
  return {"s", 1.0, "CHECK the unit: neither the heading nor the numbers show it"};
}

bool is_position(const std::string& unit) {
  static const std::vector<std::string_view> kUnits = {"m", "cm", "mm", "um", "km", "rad", "deg"};
  return std::ranges::find(kUnits, unit) != kUnits.end();
}

}  // namespace nlo::trainer
