// SPDX-License-Identifier: MIT
#include "trainer/monitor/monitor_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <nlohmann/json.hpp>

#include "trainer/evaluation/text.h"

namespace nlo::trainer {

const char* alarm_name(nlo::Alarm alarm) {
  constexpr std::array<const char*, 6> kNames = {
      "", "innovation_mean", "innovation_variance", "innovation_correlation", "latent_distance", "missing"};
  return kNames[static_cast<std::size_t>(alarm)];
}

std::string monitor_text(const codegen::Monitor& monitor, const MonitorStudy& study) {
  std::string text = fmt::format(
      "limits for {} false alarms an hour, from {} h of runs as in training; gate at {} deviations of the innovation\n",
      significant(monitor.false_alarms_per_hour), significant(monitor.hours), significant(monitor.gate));
  if (study.on_logs)
    text += fmt::format("on the test logs, {} h: {} alarms an hour{}{}\n", significant(study.log_hours),
                        significant(study.on_logs->per_hour), study.on_logs->most == Alarm::kNone ? "" : ", mostly ",
                        alarm_name(study.on_logs->most));
  if (study.rows.empty()) return text;
  text += fmt::format(
      "{} runs of {} s a condition, time constant {} s, once armed after one. error: norm of x - x_hat; ratio: over "
      "that of\n"
      "the first row; seen: runs with an alarm within five time constants; gated: error behind the gate\n\n",
      study.runs, significant(study.horizon_s), significant(study.time_constant_s));
  Table table{{"condition", "error", "ratio", "seen", "median [s]", "alarms/h", "gated", "rejected", "first alarm"}};
  for (const MonitorRow& row : study.rows)
    table.add_row({row.condition, significant(row.error), significant(row.ratio),
                   fixed(100.0 * row.alarms.seen, 1) + " %", significant(row.alarms.median_delay_s),
                   significant(row.alarms.per_hour), significant(row.gated), fixed(100.0 * row.rejected, 2) + " %",
                   alarm_name(row.alarms.most)});
  text += table.to_text(2, 110);
  if (!study.left_out.empty())
    text += fmt::format("\nleft out, for the plant has no parameters: {}\n", fmt::join(study.left_out, ", "));
  return text;
}

std::string monitor_json(const codegen::Monitor& monitor, const MonitorStudy& study) {
  nlohmann::ordered_json json;
  json["false_alarms_per_hour"] = monitor.false_alarms_per_hour;
  json["hours"] = monitor.hours;
  json["gate"] = monitor.gate;
  json["time_constant_s"] = monitor.windows_s(1);
  json["runs"] = study.runs;
  if (study.on_logs) json["test_logs"] = {{"hours", study.log_hours}, {"alarms_per_hour", study.on_logs->per_hour}};
  for (const MonitorRow& row : study.rows) {
    nlohmann::ordered_json& one = json["conditions"][row.condition];
    one["error"] = row.error;
    one["ratio"] = row.ratio;
    one["seen"] = row.alarms.seen;
    if (row.alarms.median_delay_s) one["median_delay_s"] = *row.alarms.median_delay_s;
    one["alarms_per_hour"] = row.alarms.per_hour;
    one["first_alarm"] = alarm_name(row.alarms.most);
    one["error_behind_the_gate"] = row.gated;
    one["rejected"] = row.rejected;
  }
  return json.dump(2) + "\n";
}

}  // namespace nlo::trainer
