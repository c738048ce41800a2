// SPDX-License-Identifier: MIT
// A Sensor of SimpleFOC around the C99 pair: finds the channels of the shaft's angle and velocity, and fills
// templates/simplefoc.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/base/fail.h"
#include "codegen/base/key_values.h"
#include "codegen/structures/structure_module.h"
#include "codegen/targets/around_c99.h"
#include "codegen/targets/export_parts.h"

namespace nlo::codegen {
namespace {

/// Requirements of a role. SimpleFOC uses rad and rad/s.
struct Role {
  const char* key;   ///< key of --roles
  const char* what;  ///< in messages: "output"
  const char* unit;
  std::vector<std::string_view> names;  ///< names that identify the channel if the model has no units
};

const Role kAngle = {"angle", "output", "rad", {"angle", "theta", "position", "angle_measured", "theta_measured"}};
const Role kVelocity = {"velocity", "state", "rad/s", {"velocity", "omega", "speed", "rate", "theta_dot", "angle_dot"}};
constexpr std::string_view kNone = "none";
constexpr double kTurn = 2.0 * std::numbers::pi;

/// Finds the channel of `role`: the channel that `given` names, else the only one with its unit, else one without a
/// unit that has one of its names. Returns null if no output is an angle. Throws Error that lists the channels.
const Channel* find(const Role& role, const std::string& given, const std::vector<Channel>& channels, bool may_lack) {
  const std::string known = channel_list(channels, true);
  if (may_lack && given == kNone) return nullptr;
  const Channel* found = nullptr;
  bool told = true;  // the units show that no channel is an angle
  for (const Channel& channel : channels) {
    bool is_it = channel.name == given;
    if (given.empty()) {
      is_it = channel.unit == role.unit;
      for (const std::string_view name : role.names) is_it = is_it || (channel.unit.empty() && channel.name == name);
      told = told && !channel.unit.empty() && channel.unit.find("deg") == std::string::npos && channel.unit != "°";
    }
    if (is_it && found != nullptr)
      fail("target simplefoc: both {} and {} could be the {}; write --roles {}=NAME with one of {}", found->name,
           channel.name, role.key, role.key, known);
    if (is_it) found = &channel;
  }
  if (found == nullptr && !given.empty())
    fail("--roles {}={}: there is no such {}; there are {}{}", role.key, given, role.what, known,
         may_lack ? ", or none" : "");
  if (found == nullptr && !(may_lack && told))
    fail(
        "target simplefoc: no unit or name shows which {} is the {}; give it the unit {}, or write --roles {}=NAME "
        "with one of {}{}",
        role.what, role.key, role.unit, role.key, known, may_lack ? ", or none" : "");
  if (found != nullptr && !found->unit.empty() && found->unit != role.unit)
    fail("--roles {}={}: its unit is {}, but SimpleFOC uses {}; train with that unit", role.key, found->name,
         found->unit, role.unit);
  return found;
}

/// Returns the expression of a reading in the example: a value of SimpleFOC with the same unit, else `otherwise`.
std::string given_by_motor(const Channel& channel, const char* otherwise) {
  if (channel.unit == "V") return "motor.sensor_direction * motor.voltage.q";
  if (channel.unit == "A") return "motor.sensor_direction * motor.current.q";
  return otherwise;
}

}  // namespace

std::vector<NamedText> simplefoc(const PreparedExport& prepared) {
  const Model& m = prepared.model();
  const std::string &name = prepared.name(), &roles = prepared.options().roles;
  std::map<std::string, std::string> given;
  if (!roles.empty())
    for (const auto& [key, value] : key_values(roles, "--roles")) {
      if (key != kAngle.key && key != kVelocity.key)
        fail("--roles: there is no role \"{}\"; there are angle, velocity", key);
      given[key] = value;
    }
  const std::vector<Channel> measured = measured_channels(m);
  const Channel* angle = find(kAngle, given[kAngle.key], measured, true);
  const Channel* velocity = find(kVelocity, given[kVelocity.key], m.states, false);
  const bool turns = angle != nullptr && angle->wrap > 0.0;
  if (turns && std::abs(angle->wrap - kTurn) > 1e-6)
    fail(
        "target simplefoc: the output {} wraps at {} rad, but the angle of a shaft wraps at 2 pi; train with wrap = "
        "\"2pi\"",
        angle->name, angle->wrap);

  std::string readings;
  std::vector<Channel> others;  // channels that the encoder does not measure
  for (const Channel& channel : measured)
    if (&channel != angle) {
      others.push_back(channel);
      readings += fmt::format("  y[{}_output_{}] = {};  // {}\n", name, channel.name, given_by_motor(channel, "NAN"),
                              channel_text(channel));
    }
  for (const Channel& channel : inputs(m)) {
    others.push_back(channel);
    readings += fmt::format("  u[{}_input_{}] = {};  // {}\n", name, channel.name, given_by_motor(channel, "0"),
                            channel_text(channel));
  }
  const bool single = prepared.initialiser().scalar_bytes() == 4;
  const std::string scalar = prepared.initialiser().scalar_name(), u_type = m.nu() > 0 ? ", " + scalar + "* u" : "";
  return around_c99(
      prepared, "simplefoc",
      {{"ROLES", roles.empty() ? "" : " --roles " + roles},
       {"ANGLE", angle == nullptr ? "" : name + "_output_" + angle->name},
       {"BUT_ANGLE", angle == nullptr ? "" : " beside " + angle->name + ", which is in y (and may be changed)"},
       {"TURNS", turns ? "true" : ""},
       {"VELOCITY", name + "_state_" + velocity->name},
       {"VELOCITY_TEXT", velocity->name},
       {"MOTOR_READINGS", readings},
       {"READINGS_ARGUMENT", readings.empty() ? "" : ", readings"},
       {"MICRO", single ? "1e-6f" : "1e-6"},
       {"STEPS_PER_S", fmt::format("{:.0f}U", std::clamp(std::round(1.0 / m.sample_period_s), 1.0, 1e9))},
       {"U_TYPE", u_type},
       {"ANGLE_ROW", angle == nullptr
                         ? "| the encoder | only gives the angles of SimpleFOC: it is not an output of the model |\n"
                         : fmt::format("| the encoder | is the output {}, {} |\n", channel_text(*angle),
                                       turns ? "within one turn: the observer counts the turns"
                                             : "with all turns: beyond the range of training it is clamped")},
       {"READINGS_ROW", fmt::format("| `void readings({}* y{})` | your function, which sets {}{} at each step |\n",
                                    scalar, u_type, others.empty() ? "" : channel_list(others, true),
                                    angle == nullptr ? ""
                                    : others.empty() ? "another zero or sign of the angle; may be left out"
                                                     : ", and may change the angle: its zero, its sign")},
       {"ALARM_ROW",
        m.monitor
            ? "| `alarm()` | the alarm of the monitor, 0: none; its gate filters the readings before each step |\n"
            : ""},
       {"TIME_NOTE",
        "A step is computed with the time that has really passed, so a late step adds no error of its own, but "
        "the observer does not see the readings in between."}},
      "src/");
}

}  // namespace nlo::codegen
