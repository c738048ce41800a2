// SPDX-License-Identifier: MIT
#include "codegen/targets/around_c99.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "codegen/targets/c99.h"
#include "codegen/targets/export_parts.h"

namespace nlo::codegen {

std::vector<NamedText> around_c99(const PreparedExport& given, const std::string& target,
                                  std::map<std::string, std::string> values, const std::string& sources) {
  const PreparedExport prepared = for_c99(given, target);
  const Model& m = prepared.model();
  const std::string& name = prepared.name();
  values.merge(wrapper_values(prepared));
  const std::string inputs_text = channel_list(inputs(m), true);
  if (!inputs_text.empty()) {
    values["INPUT_PORT"] = fmt::format("; 2. the known inputs ({})", inputs_text);
    values["INPUT_ROW"] = fmt::format("| input 2 | the known inputs: {} |\n", inputs_text);
  }
  std::string upper = name, readings, known;
  for (char& c : upper) c = static_cast<char>(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
  for (const Channel& channel : measured_channels(m))
    readings += fmt::format("  y[{}_output_{}] = missing;  // {}\n", name, channel.name, channel_text(channel));
  for (const Channel& channel : inputs(m))
    known += fmt::format("  u[{}_input_{}] = 0;  // {}\n", name, channel.name, channel_text(channel));
  const auto monitored = [&](const std::string& text) { return m.monitor ? text : ""; };
  values.merge(std::map<std::string, std::string>{
      {"ALARM_PORT", monitored("; 4. the monitor's alarm, " + name + "_NO_ALARM is 0")},
      {"ALARM_ROW", monitored("| output 4 | int32: the alarm of the monitor, 0: none; its gate filters the readings "
                              "before each step |\n")},
      {"ALARM_VALUE",
       monitored(", then the alarm of the monitor (0 none), whose gate filters the readings before each step")}});
  values["UPPER"] = upper;
  values["READINGS"] = readings;
  values["KNOWN"] = known;
  values["PERIOD_US"] = fmt::format("{:.0f}", std::clamp(std::round(m.sample_period_s * 1e6), 1.0, 4e9));
  std::vector<NamedText> files = c99(prepared);
  for (NamedText& file : files) file.path = sources + file.path;
  for (NamedText& file : filled_folder(target + "/", name, values)) files.push_back(std::move(file));
  return files;
}

std::vector<NamedText> simulink(const PreparedExport& prepared) {
  return around_c99(prepared, "simulink");
}

std::vector<NamedText> px4_module(const PreparedExport& prepared) {
  return around_c99(prepared, "px4");
}

}  // namespace nlo::codegen
