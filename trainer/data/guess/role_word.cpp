// SPDX-License-Identifier: MIT
#include "trainer/data/guess/role_word.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "trainer/base/trimmed.h"

namespace nlo::trainer {
namespace {

using Words = std::vector<std::string_view>;

const Words& time_words() {
  static const Words kWords = {"time",    "t",     "timestamp", "datetime", "stamp",
                               "elapsed", "clock", "millis",    "micros",   "epoch"};
  return kWords;
}

const Words& second_words() {
  static const Words kWords = {"s", "sec", "secs", "second", "seconds"};
  return kWords;
}

const Words& nanosecond_words() {
  static const Words kWords = {"ns", "nsec", "nsecs", "nanosec", "nanosecs", "nanosecond", "nanoseconds"};
  return kWords;
}

const Words& command_words() {
  static const Words kWords = {"cmd", "command", "commanded", "input", "ctrl", "control", "pwm", "duty"};
  return kWords;
}

const Words& actuator_words() {
  static const Words kWords = {"throttle", "thrust", "valve", "heater",  "actuator", "pedal",  "brake", "accelerator",
                               "steering", "steer",  "servo", "aileron", "elevator", "rudder", "gear"};
  return kWords;
}

const Words& set_point_words() {
  static const Words kWords = {"setpoint", "desired", "target", "ref", "reference"};
  return kWords;
}

const Words& truth_words() {
  static const Words kWords = {"truth", "true", "gt", "groundtruth", "mocap", "vicon", "optitrack", "exact"};
  return kWords;
}

const Words& sensor_words() {
  static const Words kWords = {"measured", "meas",       "measurement", "sensor",        "noisy",        "raw",
                               "adc",      "enc",        "encoder",     "tick",          "ticks",        "gyro",
                               "gyr",      "acc",        "accel",       "accelerometer", "imu",          "wheel",
                               "odom",     "odometry",   "odometer",    "baro",          "barometer",    "mag",
                               "gps",      "gnss",       "lidar",       "sonar",         "magnetometer", "hall",
                               "resolver", "thermistor", "tacho",       "tachometer",    "potentiometer"};
  return kWords;
}

const Words& aside_words() {
  static const Words kWords = {"id",     "index", "row",  "counter", "seq",   "sequence",   "frame", "clean",
                               "status", "mode",  "flag", "flags",   "valid", "covariance", "error"};
  return kWords;
}

const Words& charge_words() {
  static const Words kWords = {"soc", "soh"};
  return kWords;
}

const Words& voltage_words() {
  static const Words kWords = {"voltage", "volt", "volts"};
  return kWords;
}

/// Returns the words of a supply voltage, which is not a command.
const Words& supply_words() {
  static const Words kWords = {"battery", "batt", "bat", "supply", "bus", "cell", "pack"};
  return kWords;
}

const Words& current_words() {
  static const Words kWords = {"current", "amps"};
  return kWords;
}

const Words& temperature_words() {
  static const Words kWords = {"temperature", "temp"};
  return kWords;
}

const Words& sensed_words() {
  static const Words kWords = {"current",      "amps",      "temperature", "temp",           "pressure", "humidity",
                               "acceleration", "rpm",       "voltage",     "volt",           "volts",    "yawrate",
                               "rollrate",     "pitchrate", "airspeed",    "angularvelocity"};
  return kWords;
}

bool is_among(std::string_view word, const Words& words) {
  return std::ranges::find(words, word) != words.end();
}

/// Returns the first word of a heading that is in `words`, by the rules of role_word(); empty: none.
std::string among(const Heading& heading, const Words& words) {
  constexpr std::size_t kShortestPair = 3;  // "i_d" is not "id"
  const auto counts = [&](const std::string& word) {
    return is_among(word, words) || is_among(trimmed(word, "0123456789"), words);
  };
  for (std::size_t i = 0; i < heading.words.size(); ++i) {
    if (counts(heading.words[i])) return heading.words[i];
    if (i + 1 == heading.words.size()) break;
    const std::string pair = heading.words[i] + heading.words[i + 1];
    if (pair.size() >= kShortestPair && counts(pair)) return heading.words[i] + " " + heading.words[i + 1];
  }
  return "";
}

bool has(const Heading& heading, const Words& words) {
  return !among(heading, words).empty();
}

bool has_heading(const std::vector<Heading>& all, const std::string& name) {
  return std::ranges::find(all, name, &Heading::name) != all.end();
}

/// Returns true if the heading is the letter alone, or with a number: "u" or "u2".
bool is_letter(const Heading& heading, char letter) {
  return heading.name.size() <= 2 && heading.name.front() == letter &&
         (heading.name.size() == 1 || (heading.name[1] >= '0' && heading.name[1] <= '9'));
}

/// Returns true for "ax" or "gy" if there is another axis with the same letter: an accelerometer, a gyro.
bool is_axis(const Heading& heading, const std::vector<Heading>& all) {
  constexpr std::string_view kLetters = "ag", kAxes = "xyz";
  const std::string& name = heading.name;
  if (name.size() != 2 || kLetters.find(name[0]) == kLetters.npos || kAxes.find(name[1]) == kAxes.npos) return false;
  return std::ranges::any_of(kAxes, [&](char axis) { return axis != name[1] && has_heading(all, {name[0], axis}); });
}

bool is_charge(const Heading& heading) {
  return has(heading, charge_words()) || heading.name.find("state_of_charge") != std::string::npos;
}

/// Returns a role in a log with a state of charge: the voltage is measured, and the load draws the current.
RoleWord battery_role(const Heading& heading) {
  if (is_charge(heading)) return {ColumnRole::kState, false, "a state of charge: no sensor measures it"};
  if (has(heading, voltage_words()) || heading.unit == "V" || heading.unit == "mV" || is_letter(heading, 'v'))
    return {ColumnRole::kOutput, false, "the voltage of a battery: a sensor"};
  if (has(heading, current_words()) || heading.unit == "A" || heading.unit == "mA" || is_letter(heading, 'i'))
    return {ColumnRole::kInput, false, "the current of a battery: drawn by the load, and measured"};
  if (has(heading, temperature_words()) || heading.unit == "degC" || is_letter(heading, 't'))
    return {ColumnRole::kOutput, false, "a temperature beside a battery: a sensor"};
  return {};
}

bool is_driving_voltage(const Heading& heading) {
  return has(heading, voltage_words()) && !has(heading, supply_words()) && !has(heading, sensor_words());
}

bool has_command(const std::vector<Heading>& all) {
  return std::ranges::any_of(all, [](const Heading& heading) {
    return is_letter(heading, 'u') || is_driving_voltage(heading) ||
           (!has(heading, set_point_words()) && (has(heading, command_words()) || has(heading, actuator_words())));
  });
}

}  // namespace

bool is_time_word(const Heading& heading) {
  if (heading.words.empty()) return false;
  const bool is_unit =
      heading.words.size() == 1 && (heading.name == "s" || heading.name == "ms" || heading.name == "us" ||
                                    heading.name == "sec" || heading.name == "seconds");
  static const Words kStamps = {"stamp", "timestamp", "datetime"};
  const auto has_word = [&](const Words& words) {
    return std::ranges::any_of(heading.words, [&](const std::string& word) { return is_among(word, words); });
  };
  return is_unit || heading.words.front() == "time" || heading.words.back() == "time" || has_word(kStamps) ||
         (heading.words.size() <= 2 && has_word(time_words()) && heading.words.front() != "u");
}

bool is_half_stamp(const Heading& heading, const std::vector<Heading>& all) {
  if (heading.words.empty()) return false;
  const auto is_other_half = [&](const Words& mine, const Words& others) {
    return is_among(heading.words.back(), mine) && std::ranges::any_of(all, [&](const Heading& other) {
             return other.words.size() == heading.words.size() && is_among(other.words.back(), others) &&
                    std::equal(heading.words.begin(), heading.words.end() - 1, other.words.begin());
           });
  };
  return is_other_half(second_words(), nanosecond_words()) || is_other_half(nanosecond_words(), second_words());
}

RoleWord role_word(const Heading& heading, const std::vector<Heading>& all) {
  const auto in_heading = [](const std::string& word, std::string_view meaning) {
    return fmt::format("\"{}\" in its heading: {}", word, meaning);
  };
  const auto aside = [](const std::string& word) {
    return RoleWord{ColumnRole::kIgnored, true,
                    fmt::format("\"{}\" is neither a measurement nor an input of the plant", word)};
  };
  const bool is_current_of_axis = heading.name == "id" && has_heading(all, "iq");
  if (const std::string word = among(heading, aside_words()); !word.empty() && !is_current_of_axis) return aside(word);
  if (const std::string word = among(heading, truth_words()); !word.empty())
    return {ColumnRole::kState, false, in_heading(word, "the truth, which is only known in a log")};
  const std::string actuator = has(heading, temperature_words()) ? "" : among(heading, actuator_words());
  if (const std::string word = among(heading, set_point_words()); !word.empty() && actuator.empty()) {
    if (has_command(all)) return aside(word);
    return {ColumnRole::kInput, false,
            in_heading(word, "CHECK: a set point; no column is the command that follows from it")};
  }
  if (const std::string word = among(heading, command_words()); !word.empty())
    return {ColumnRole::kInput, false, in_heading(word, "the command of a controller")};
  if (!actuator.empty()) return {ColumnRole::kInput, false, in_heading(actuator, "the command of a controller")};
  if (std::ranges::any_of(all, is_charge))
    if (RoleWord role = battery_role(heading); !role.why.empty()) return role;
  if (is_letter(heading, 'u'))
    return {ColumnRole::kInput, false, in_heading(heading.name, "the command of a controller")};
  if (const std::string word = among(heading, sensor_words()); !word.empty())
    return {ColumnRole::kOutput, false, in_heading(word, "a sensor")};
  if (is_axis(heading, all))
    return {ColumnRole::kOutput, false, "an axis of an accelerometer or a gyro by its letters"};
  for (const char* suffix : {"_measured", "_meas", "_noisy", "_raw", "_sensor"})
    if (has_heading(all, heading.name + suffix))
      return {ColumnRole::kIgnored, true,
              fmt::format("\"{}{}\" is the measurement of the same quantity", heading.name, suffix)};
  if (is_driving_voltage(heading))
    return {ColumnRole::kInput, false, in_heading(among(heading, voltage_words()), "CHECK: it drives a motor?")};
  if (is_letter(heading, 'y') && !has_heading(all, "x")) return {ColumnRole::kOutput, false, "an output by its letter"};
  return {};
}

std::string sensed_quantity(const Heading& heading) {
  if (const std::string word = among(heading, sensed_words()); !word.empty()) return fmt::format("\"{}\"", word);
  static const Words kUnits = {"m/s^2", "g", "A", "mA", "V", "mV", "rpm", "degC", "hPa", "kPa", "Pa", "mbar", "bar"};
  return is_among(heading.unit, kUnits) ? fmt::format("its unit, {},", heading.unit) : "";
}

}  // namespace nlo::trainer
