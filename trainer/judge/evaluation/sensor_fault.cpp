// SPDX-License-Identifier: MIT
#include "trainer/judge/evaluation/sensor_fault.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <utility>

#include "codegen/base/error.h"
#include "trainer/base/number_text.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {
namespace {

using codegen::Error;

constexpr std::array<std::pair<std::string_view, SensorFault::Kind>, 3> kKinds = {
    {{"missing", SensorFault::Kind::kMissing},
     {"stuck", SensorFault::Kind::kStuck},
     {"dead", SensorFault::Kind::kDead}}};

}  // namespace

SensorFault parse_fault(std::string_view word) {
  const auto refuse = [&] {
    throw Error(
        fmt::format("--missing {}: is not OUTPUT, OUTPUT:stuck or OUTPUT:dead, optionally followed by :SECONDS", word));
  };
  const std::size_t first = word.find(':'), second = first == word.npos ? first : word.find(':', first + 1);
  SensorFault fault{std::string(word.substr(0, first))};
  if (fault.output.empty()) refuse();
  if (first == word.npos) return fault;
  const std::string_view named = word.substr(first + 1, second == word.npos ? second : second - first - 1);
  const auto* kind = std::find_if(kKinds.begin(), kKinds.end(), [&](const auto& row) { return row.first == named; });
  if (kind == kKinds.end()) refuse();
  fault.kind = kind->second;
  if (second == word.npos) return fault;
  const auto after_s = finite_number(word.substr(second + 1));
  if (!after_s || *after_s < 0.0) refuse();
  fault.after_s = *after_s;
  return fault;
}

std::string format_fault(const SensorFault& fault) {
  std::string text = fault.output;
  for (const auto& [name, kind] : kKinds)
    if (kind == fault.kind && kind != SensorFault::Kind::kMissing) text += fmt::format(":{}", name);
  return fault.after_s > 0.0 ? fmt::format("{} from {} s on", text, significant(fault.after_s)) : text;
}

std::vector<SensorFault> missing_alone(const std::vector<SensorFault>& faults) {
  std::vector<SensorFault> told;
  std::copy_if(faults.begin(), faults.end(), std::back_inserter(told),
               [](const SensorFault& fault) { return fault.kind == SensorFault::Kind::kMissing; });
  return told;
}

Dataset with_faults(Dataset logs, const std::vector<SensorFault>& faults) {
  for (const SensorFault& fault : faults) {
    const auto found = std::find_if(logs.outputs.begin(), logs.outputs.end(),
                                    [&](const Channel& output) { return output.name == fault.output; });
    if (found == logs.outputs.end()) {
      std::string names;
      for (const Channel& output : logs.outputs) names += (names.empty() ? "" : ", ") + output.name;
      throw Error(fmt::format("--missing {}: there is no such output; there are {}", fault.output, names));
    }
    for (Trajectory& run : logs.trajectories) {
      auto y = run.outputs.row(found - logs.outputs.begin());
      double value = fault.kind == SensorFault::Kind::kMissing ? std::numeric_limits<double>::quiet_NaN() : 0.0;
      for (Eigen::Index k = 0; k < y.size(); ++k) {
        if (run.time_s[k] - run.time_s[0] < fault.after_s) {
          if (fault.kind == SensorFault::Kind::kStuck && std::isfinite(y[k])) value = y[k];
          continue;
        }
        if (k == 0 && fault.kind == SensorFault::Kind::kStuck) value = y[k];
        y[k] = value;
      }
    }
  }
  logs.compute_outputs();
  return logs;
}

}  // namespace nlo::trainer
