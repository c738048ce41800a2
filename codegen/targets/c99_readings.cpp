// SPDX-License-Identifier: MIT
#include "codegen/targets/c99_readings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "codegen/fold/fold.h"
#include "codegen/structures/structure_module.h"

namespace nlo::codegen {
namespace {

using Values = std::map<std::string, std::string>;

void set_inputs(const Model& m, const std::string& name, const std::string& scalar, Values& values) {
  const bool command = module_of(m).input_hold(m) == Hold::kZeroOrder;
  const int size = m.nu();
  values["PUBLIC_SIZES"] = fmt::format(", {}_NU = {}", name, size);
  values["MORE_SIZES"] += fmt::format(", kNu = {}", size);
  values["SIZES_MORE"] = ", inputs";
  values["INPUT_POSITIONS"] = fmt::format("enum {{ {} }};\n", c99_positions(name + "_input_", inputs(m)));
  values["AND_MORE"] += " and input";
  values["U_PARAMETER"] = fmt::format(", const {} u[{}]", scalar, size);
  values["U_TAKEN"] = ", const Scalar* u";
  values["U_PASSED"] = ", u";
  values["INPUT_NOTE"] = fmt::format("// u: the inputs {}. If one is not finite, its last good value is held.\n",
                                     command ? "that have acted since the last sample" : "measured with y");
  if (command) values["HOLD_INPUTS"] = "  copy(o->y + kNy, next + kNy, kNu);  // u has acted since the last sample\n";
  values["READ"] += "  copy(given + kNy, u, kNu);\n";
  if (acting_inputs(m) > 0) {
    values["START_READ"] += "  load(given + kNy, kNoOutput, kNu);\n";
  } else {
    values["START_READ"] += "  copy(given + kNy, u, kNu);\n";
    values["START_U"] = values["U_PARAMETER"];
  }
}

/// Sets the values for computed outputs, which are expressions of the arguments of step().
void set_computed(const Model& m, const Initialiser& init, Values& values) {
  values["COMPUTE"] =
      "// Computes outputs from the measured readings.\nstatic void compute(Scalar* r) {\n" +
      computed_statements(m, init, "  ", [](const std::string& product) { return "(" + product + ")"; }) + "}\n\n";
  for (const char* key : {"READ", "START_READ"}) values[key] += "  compute(given);\n";
}

/// Returns true if a slow output may fail. Such an output fades once it is late.
bool has_slow_failing(const Model& m) {
  const std::vector<int> samples = not_due(m);
  return std::ranges::any_of(m.failures.outputs, [&](int j) { return samples[static_cast<std::size_t>(j)] > 0; });
}

/// Sets the values for sensors that may fail; nlo/sensor_failures.h has the equations.
void set_failures(const Model& m, const std::string& name, const Initialiser& init, Values& values) {
  const SensorFailures& f = m.failures;
  const std::string suffix = init.scalar_bytes() == 4 ? "f" : "";
  values["MORE_SIZES"] += fmt::format(", kNf = {}", f.outputs.size());
  values["AND_MORE"] += ", and how stale those are that may be missing";
  values["KEEP_FIELD"] = "  Scalar keep;  // what is left of a missing output over the step\n";
  values["KEEP_VALUE"] = ",\n    " + init(std::exp(-m.sample_period_s / f.staleness_s), "may_fail.staleness_s");
  values["KEEP_OVER"] = fmt::format("  step->keep = decay_minus_1({0} * h) + 1.0{1};  // exp(-h / staleness_s)\n",
                                    init(1.0 / f.staleness_s, "may_fail.staleness_s"), suffix);
  values["FILL_MISSING"] = "c99/may_fail.c.in";
  values["MAY_FAIL"] = fmt::format("{{{}}}", fmt::join(f.outputs.begin(), f.outputs.end(), ", "));
  values["REST_OF_MISSING"] = init.vector(f.rest, "may_fail.rest");
  const bool fades = !values["FADES"].empty();
  const auto fill = [&](const char* observer, const std::string& keep) {
    return fmt::format("  bool missing[kNf];\n{}  fill_missing({}, given, {}0.0{}, missing{});\n",
                       fades ? "  uint16_t absent[kNf];\n" : "", observer, keep, suffix, fades ? ", absent" : "");
  };
  const auto mark = [&](const char* observer) {
    return fmt::format("  mark_missing({}, missing{});\n", observer, fades ? ", absent" : "");
  };
  values["FILL"] = fill("o", "(o->started == 1U) ? step->keep : ");
  values["NOTE_MISSING"] = mark("o");
  values["FILL_START"] = fill("observer", "");
  values["NOTE_MISSING_START"] = mark("observer");
  values["STALENESS"] = fmt::format(
      "// Returns the staleness of an output that may be missing ({1}): 0 while it is measured; it approaches 1 while "
      "it "
      "is missing.\n"
      "{2} {0}_staleness(const {0}_observer* observer, int output);\n\n",
      name,
      fmt::join(
          [&] {
            std::vector<std::string> names;
            for (const int output : f.outputs) names.push_back(m.outputs[static_cast<std::size_t>(output)].name);
            return names;
          }(),
          ", "),
      init.scalar_name());
  std::string cases;
  for (std::size_t i = 0; i < f.outputs.size(); ++i)
    cases += fmt::format("(output == {}) ? observer->y[kNr - {}] : ", f.outputs[i], f.outputs.size() - i);
  values["STALENESS_BODY"] =
      fmt::format("Scalar {0}_staleness(const {0}_observer* observer, int output) {{\n  return {1}0.0{2};\n}}\n\n",
                  name, cases, suffix);
}

}  // namespace

std::string c99_positions(const std::string& prefix, const std::vector<Channel>& channels) {
  std::string text;
  for (const Channel& channel : channels) text += (text.empty() ? "" : ", ") + prefix + channel.name;
  return text;
}

int acting_inputs(const Model& m) {
  return m.nu() - static_cast<int>(m.inputs.size());
}

std::string c99_held_size(const Model& m) {
  return m.nr() + acting_inputs(m) == m.ny() ? "kNy" : "kNr";
}

std::string c99_readings_size(const Model& m) {
  return m.nr() == m.ny() ? "kNy" : "kNr";
}

std::map<std::string, std::string> c99_readings(const Model& m, const std::string& name, const Initialiser& init) {
  Values values;
  for (const char* key :
       {"MORE_SIZES", "PUBLIC_SIZES", "SIZES_MORE",   "INPUT_POSITIONS", "AND_MORE",       "U_PARAMETER",
        "U_TAKEN",    "START_U",      "START_READ",   "U_PASSED",        "INPUT_NOTE",     "HOLD_INPUTS",
        "READ",       "NOTE_MISSING", "COMPUTE",      "KEEP_FIELD",      "KEEP_VALUE",     "KEEP_OVER",
        "FILL",       "FILL_START",   "FILL_MISSING", "STALENESS",       "STALENESS_BODY", "NOTE_MISSING_START",
        "SLOW",       "NOT_DUE",      "FADES",        "ARRIVALS",        "ARRIVED"})
    values[key] = "";
  if (has_slow_outputs(m)) {
    std::vector<int> samples = not_due(m);
    samples.resize(samples.size() + static_cast<std::size_t>(acting_inputs(m)), 0);
    values["SLOW"] = "true";
    values["NOT_DUE"] = fmt::format("{{{}}}", fmt::join(samples, ", "));
    if (has_slow_failing(m)) {
      for (std::size_t j = 0; j < samples.size(); ++j)
        samples[j] = samples[j] > 0 && std::ranges::count(m.failures.outputs, static_cast<int>(j)) > 0 ? 1 : 0;
      values["FADES"] = fmt::format("{{{}}}", fmt::join(samples, ", "));
    }
  }
  values["READINGS"] = "y";
  values["CHANNELS"] = std::to_string(m.ny() + m.nu());
  values["CHANNEL_NOTE"] =
      m.nu() == 0 ? "an output's position" : fmt::format("an output's position, or {} + an input's", m.ny());
  const int held = m.nr() + acting_inputs(m);
  if (held == m.measured()) return values;
  if (held > m.ny()) values["MORE_SIZES"] = fmt::format(", kNr = {}", held);
  values["READ"] = fmt::format("  Scalar given[{}];\n  copy(given, y, {});\n", c99_held_size(m),
                               m.measured() == m.ny() ? "kNy" : std::to_string(m.measured()));
  values["START_READ"] = values["READ"];
  values["READINGS"] = "given";
  if (m.nu() > 0) set_inputs(m, name, init.scalar_name(), values);
  if (m.measured() < m.ny()) set_computed(m, init, values);
  if (!m.failures.none()) set_failures(m, name, init, values);
  return values;
}

}  // namespace nlo::codegen
