// SPDX-License-Identifier: MIT
#include "trainer/guess/heading.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "codegen/base/identifier.h"

namespace nlo::trainer {
namespace {

using Unit = std::pair<std::string_view, std::string_view>;  // as headings end, and as it is written here

// The longest first: "_m_s" is no time.
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

constexpr auto kDoubtful =
    std::to_array<Unit>({{"_a", "A"}, {"_g", "g"}, {"_n", "N"}, {"_v", "V"}, {"_w", "W"}, {"_k", "K"}, {"_l", "l"}});

std::string lower(std::string_view text) {
  std::string result(text);
  std::ranges::transform(result, result.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

std::string trimmed(std::string text) {
  const auto blank = [](unsigned char c) { return std::isspace(c) != 0; };
  while (!text.empty() && blank(static_cast<unsigned char>(text.back()))) text.pop_back();
  text.erase(text.begin(), std::ranges::find_if_not(text, blank));
  return text;
}

/// "°C" and the like as they are written here.
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

/// Takes "(m)" or "[m]" off the end of a heading.
bool take_brackets(std::string& heading, std::string& unit) {
  for (const auto& [open, close] : {std::pair{'[', ']'}, std::pair{'(', ')'}}) {
    const auto from = heading.rfind(open);
    if (heading.empty() || heading.back() != close || from == std::string::npos || from == 0) continue;
    unit = written(trimmed(heading.substr(from + 1, heading.size() - from - 2)));
    heading = trimmed(heading.substr(0, from));
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
  std::string rest = trimmed(heading);
  if (!take_brackets(rest, result.unit)) take_suffix(rest, result.unit, all);
  std::string word;
  const auto end_word = [&] {
    if (!word.empty()) result.words.push_back(std::exchange(word, ""));
  };
  bool after_small = false;
  for (const char c : rest) {
    const auto byte = static_cast<unsigned char>(c);
    const bool is_letter = byte < 0x80 && std::isalnum(byte) != 0, is_big = is_letter && std::isupper(byte) != 0;
    if (!is_letter || (is_big && after_small)) end_word();
    if (is_letter) word += static_cast<char>(std::tolower(byte));
    after_small = is_letter && !is_big;
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

}  // namespace nlo::trainer
