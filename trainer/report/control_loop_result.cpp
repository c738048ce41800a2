// SPDX-License-Identifier: MIT
#include "trainer/report/control_loop_result.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "trainer/evaluation/text.h"

namespace nlo::trainer {
namespace {

using Json = nlohmann::json;

template <class T>
void read(const Json& json, const char* field, T& value) {
  value = json.at(field).get<T>();
}

void read(const Json& json, const char* field, ControlLoopResult::Quantiles& value) {
  const Json& quantiles = json.at(field);
  read(quantiles, "p50", value.p50);
  read(quantiles, "p99", value.p99);
  read(quantiles, "p99_9", value.p99_9);
  read(quantiles, "max", value.max);
}

}  // namespace

ControlLoopResult parse_control_loop(std::string_view text, const std::string& name) {
  try {
    const Json json = Json::parse(text);
    ControlLoopResult result;
    read(json, "rate_hz", result.rate_hz);
    read(json, "ticks", result.ticks);
    read(json, "noise_std", result.noise_std);
    read(json, "rms_error", result.rms_error);
    read(json, "settled_rms_error", result.settled_rms_error);
    read(json, "missed_deadlines", result.missed_deadlines);
    read(json, "faults", result.faults);
    read(json, "outside_domain", result.outside_domain);
    read(json, "real_time_priority", result.real_time_priority);
    read(json, "memory_locked", result.memory_locked);
    read(json, "step_and_estimate_ns", result.step_and_estimate);
    read(json, "wake_up_lateness_ns", result.wake_up_lateness);
    for (const Json& bucket : json.at("step_and_estimate_histogram")) {
      ControlLoopResult::Bucket& entry = result.histogram.emplace_back();
      read(bucket, "below_ns", entry.below_ns);
      read(bucket, "count", entry.count);
    }
    return result;
  } catch (const Json::exception& error) {
    throw codegen::Error(fmt::format(
        "{}: is not the result of a control loop ({}); write it again with control_loop --json", name, error.what()));
  }
}

ControlLoopResult read_control_loop(const std::string& path) {
  constexpr std::size_t kMaxBytes = 1 << 20;  // a real one has two kilobytes
  return parse_control_loop(codegen::read_file(path, kMaxBytes), path);
}

std::string nanoseconds(double ns) {
  if (ns < 1e3) return fmt::format("{} ns", fixed(ns, 0));
  return ns < 1e6 ? fmt::format("{} µs", significant(ns / 1e3)) : fmt::format("{} ms", significant(ns / 1e6));
}

}  // namespace nlo::trainer
