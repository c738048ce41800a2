// SPDX-License-Identifier: MIT
#include "codegen/targets/c99_monitor.h"

#include <fmt/format.h>
#include <nlo/monitor_model.h>

#include <cctype>

#include "codegen/base/embedded_text.h"
#include "codegen/fold/fold.h"
#include "codegen/text/cpp_monitor.h"

namespace nlo::codegen {
namespace {

/// Returns the name of the constant for a field: "mean_limit" gives kWatchMeanLimit.
std::string constant_name(const std::string& field) {
  std::string name = "kWatch";
  bool upper = true;
  for (const char c : field) {
    if (c != '_') name += upper ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    upper = c == '_';
  }
  return name;
}

}  // namespace

void add_c99_monitor(const Model& m, const Initialiser& init, std::map<std::string, std::string>& values) {
  values["MONITOR"] = values["MONITOR_BODY"] = "";
  if (!m.monitor) return;
  std::string constants;
  for (const MonitorConstant& c : monitor_constants(m, init))
    constants += fmt::format("static const IN_FLASH {} {}{} = {};\n", c.type, constant_name(c.name), c.extents, c.text);
  values["CONSTANTS"] = constants;
  values["PROMISE"] = monitor_promise(*m.monitor);
  values["WINDOWS"] = std::to_string(m.monitor->windows());
  values["MOST_REJECTED"] = std::to_string(kMostRejected);
  values["LARGEST_INNOVATION"] = init(kLargestInnovation, "largest innovation");
  values["FREEZES"] = m.monitor->freezes_none() ? "" : "true";
  values["MOVES"] = m.monitor->scales_with_motion() ? "true" : "";
  values["PLACE_OF_MONITOR"] = m.monitor->scales_with_motion() ? ", monitor->place" : "";
  values["REPLACES"] = m.monitor->replaces_any() ? "true" : "";
  values["AGREES"] = m.monitor->compares_row() ? "true" : "";
  values["AGREEMENT_WINDOW"] = m.monitor->windows() > 1 ? "1" : "0";
  values["AND_ARRIVED"] = has_slow_outputs(m) ? " && arrived" : "";
  values["COMPUTES"] = m.measured() < m.ny() ? "true" : "";
  values["MONITOR"] = "\n" + std::string(embedded_text("c99/monitor.h.in"));
  values["MONITOR_BODY"] = embedded_text("c99/monitor.c.in");
}

}  // namespace nlo::codegen
