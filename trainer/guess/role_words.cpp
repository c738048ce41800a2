// SPDX-License-Identifier: MIT
#include "trainer/guess/role_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace nlo::trainer {
namespace {

using Words = std::vector<std::string_view>;

const Words& time_words() {
  static const Words kWords = {"time", "t", "timestamp", "stamp", "elapsed", "clock", "millis", "micros", "epoch"};
  return kWords;
}

const Words& input_words() {
  static const Words kWords = {"u",    "cmd",      "command", "commanded", "input",  "ctrl",     "control", "pwm",
                               "duty", "throttle", "thrust",  "valve",     "heater", "actuator", "pedal",   "brake"};
  return kWords;
}

const Words& truth_words() {
  static const Words kWords = {"truth", "true", "gt", "groundtruth", "mocap", "vicon", "optitrack", "exact"};
  return kWords;
}

const Words& sensor_words() {
  static const Words kWords = {"measured", "meas",    "measurement", "sensor", "noisy",        "raw",   "adc",
                               "enc",      "encoder", "gyro",        "gyr",    "acc",          "accel", "accelerometer",
                               "imu",      "baro",    "barometer",   "mag",    "magnetometer", "gps",   "gnss",
                               "lidar",    "sonar",   "thermistor",  "tacho",  "potentiometer"};
  return kWords;
}

const Words& aside_words() {
  static const Words kWords = {"setpoint", "desired", "target", "id", "index", "row", "counter", "clean"};
  return kWords;
}

/// The first word of a heading that is among some; empty: none is.
std::string among(const Heading& heading, const Words& words) {
  for (const std::string& word : heading.words)
    if (std::ranges::find(words, word) != words.end()) return word;
  return "";
}

bool has_heading(const std::vector<std::string>& all, const std::string& name) {
  return std::ranges::any_of(all, [&](const std::string& heading) { return read_heading(heading, all).name == name; });
}

/// "u", "u2": the letter by itself.
bool is_letter(const Heading& heading, char letter) {
  return heading.name.size() <= 2 && heading.name.front() == letter &&
         (heading.name.size() == 1 || (heading.name[1] >= '0' && heading.name[1] <= '9'));
}

}  // namespace

bool is_time_word(const Heading& heading) {
  if (heading.words.empty()) return false;
  const bool is_unit =
      heading.words.size() == 1 && (heading.name == "s" || heading.name == "ms" || heading.name == "us" ||
                                    heading.name == "sec" || heading.name == "seconds");
  return is_unit || heading.words.front() == "time" || heading.words.back() == "time" ||
         (heading.words.size() <= 2 && !among(heading, time_words()).empty() && heading.words.front() != "u");
}

TimeUnit time_unit(const Heading& heading, const ColumnNumbers& stamps) {
  static const std::array<TimeUnit, 4> kUnits = {
      {{"s", 1.0, ""}, {"ms", 1e-3, ""}, {"us", 1e-6, ""}, {"ns", 1e-9, ""}}};
  const std::string word = heading.name == "millis" || heading.name == "ms"   ? "ms"
                           : heading.name == "micros" || heading.name == "us" ? "us"
                                                                              : heading.unit;
  for (const TimeUnit& unit : kUnits)
    if (word == unit.name) return {unit.name, unit.seconds, "its unit by the heading"};
  constexpr double kFewest = 1.0, kMost = 1e4;  // rows a second
  const double step = stamps.steps().median;
  const std::size_t first = stamps.is_whole() && step > 1.0 ? 1 : 0;
  for (std::size_t i = first; i < kUnits.size(); ++i) {
    const double rate = 1.0 / (step * kUnits[i].seconds);
    if (rate < kFewest || rate > kMost) continue;
    return {kUnits[i].name, kUnits[i].seconds,
            fmt::format("CHECK its unit: steps of {:g} are {:g} rows a second in {}", step, rate, kUnits[i].name)};
  }
  return {"s", 1.0, "CHECK its unit: nothing tells it"};
}

RoleWord role_word(const Heading& heading, const std::vector<std::string>& all_headings) {
  if (const std::string word = among(heading, aside_words()); !word.empty())
    return {ColumnRole::kIgnored, true, fmt::format("\"{}\" is neither measured nor what acts", word)};
  if (const std::string word = among(heading, truth_words()); !word.empty())
    return {ColumnRole::kState, false, fmt::format("\"{}\" in its heading: the truth, which only a log has", word)};
  if (const std::string word = among(heading, input_words()); !word.empty() && (word != "u" || is_letter(heading, 'u')))
    return {ColumnRole::kInput, false, fmt::format("\"{}\" in its heading: what a controller commands", word)};
  if (const std::string word = among(heading, sensor_words()); !word.empty())
    return {ColumnRole::kOutput, false, fmt::format("\"{}\" in its heading: a sensor", word)};
  for (const char* suffix : {"_measured", "_meas", "_noisy", "_raw", "_sensor"})
    if (has_heading(all_headings, heading.name + suffix))
      return {ColumnRole::kIgnored, true,
              fmt::format("\"{}{}\" is the same as a sensor gives it", heading.name, suffix)};
  if (is_letter(heading, 'u')) return {ColumnRole::kInput, false, "an input by its letter"};
  if (is_letter(heading, 'y') && !has_heading(all_headings, "x"))
    return {ColumnRole::kOutput, false, "an output by its letter"};
  return {};
}

bool is_position(const std::string& unit) {
  static const Words kUnits = {"m", "cm", "mm", "um", "km", "rad", "deg"};
  return std::ranges::find(kUnits, unit) != kUnits.end();
}

}  // namespace nlo::trainer
