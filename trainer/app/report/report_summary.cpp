// SPDX-License-Identifier: MIT
#include "trainer/app/report/report_summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "trainer/app/report/html.h"
#include "trainer/data/measurement_noise.h"

namespace nlo::trainer {
namespace {

std::string tile(const std::string& value, const std::string& meaning) {
  return fmt::format("<div class=\"tile\"><b>{}</b><span>{}</span></div>\n", escaped(value), escaped(meaning));
}

const Evaluation* named(const StudyRow& row, std::string_view name) {
  for (const StudyCell& cell : row.cells)
    if (cell.first().estimator == name) return &cell.first();
  return nullptr;
}

/// Returns the settled window in words: "settled (t >= 10 s)".
std::string settled_text(const ErrorMetrics& metrics) {
  EvaluationWindows windows;
  for (const ErrorMetrics::Window& window : metrics.windows) windows.push_back(window.window);
  return window_text(windows[settled_window(windows)]);
}

}  // namespace

const StudyRow* main_row(const std::vector<StudyRow>& rows) {
  const auto first_with = [&](auto&& is_meant) -> const StudyRow* {
    for (const StudyRow& row : rows)
      if (std::ranges::any_of(row.observer().first().noise.sensors, is_meant)) return &row;
    return nullptr;
  };
  if (const auto* gaussian = first_with([](const SensorNoise& noise) { return noise.kind == NoiseKind::kGaussian; }))
    return gaussian;
  if (const auto* noisy = first_with([](const SensorNoise& noise) { return noise.kind != NoiseKind::kNone; }))
    return noisy;
  return first_with([](const SensorNoise&) { return true; });
}

std::string plant_summary(const StudyRow& row) {
  const Evaluation& observer = row.observer().first();
  const ErrorMetrics& own = observer.metrics;
  std::string text = fmt::format(
      "With {} on its measurements the error of the observer is {} (root mean square over {} runs of {} s, "
      "transient included{})",
      noise_title(observer.noise), significant(own.norm), observer.trajectories, significant(observer.horizon_s, 2),
      own.normalised ? "; each state divided by its standard deviation" : "");
  if (own.nrmse) text += fmt::format(", {} of the state's own size", percent(*own.nrmse));
  text += ".";
  if (own.settled)
    text +=
        own.settling_time_s
            ? fmt::format(" It settles within {} s to {}.", fixed(*own.settling_time_s, 1), significant(*own.settled))
            : fmt::format(" Once settled the error is {}, but it does not stay there.", significant(*own.settled));
  if (const Evaluation* ekf = named(row, "ekf"))
    text += fmt::format(" An extended Kalman filter that is given the exact plant and noise reaches {}.",
                        significant(ekf->metrics.norm));
  if (const Evaluation* constant = named(row, "constant"))
    text += fmt::format(" Always estimating the mean would have an error of {}{}.", significant(constant->metrics.norm),
                        own.norm >= constant->metrics.norm ? ", which is no larger: this observer is useless" : "");
  return text;
}

std::string log_summary(const LogEvaluation& logs) {
  const LogMetrics& own = logs.entries.front().metrics;
  const std::size_t settled = settled_window(own.windows);
  const bool one = own.files.size() == 1;
  const std::string kind = logs.split.empty() || logs.split == "test" ? "" : logs.split + " ";
  std::string text =
      fmt::format("On {}{}{}: ", one ? "a " : fmt::format("{} ", own.files.size()), kind, one ? "log" : "logs");
  if (kind.empty())
    text =
        fmt::format("On {} that {} not used for training: ", one ? "a log" : fmt::format("{} logs", own.files.size()),
                    one ? "was" : "were");
  for (std::size_t i = 0; i < own.pooled.size(); ++i) {
    const StateError& state = own.pooled[i];
    const LogEntry* best = nullptr;
    for (std::size_t e = 1; e < logs.entries.size(); ++e) {
      const double error = logs.entries[e].metrics.pooled[i].rmse[settled];
      if (std::isfinite(error) && (best == nullptr || error < best->metrics.pooled[i].rmse[settled]))
        best = &logs.entries[e];
    }
    text += fmt::format("{}{}: error {}{}{}, {}", i > 0 ? "; " : "", state.name, significant(state.rmse[settled]),
                        state.unit.empty() ? "" : " ", state.unit, window_text(own.windows[settled]));
    if (best != nullptr)
      text += fmt::format(" (best alternative: {}, {})", best->estimator,
                          significant(best->metrics.pooled[i].rmse[settled]));
  }
  return text + ".";
}

std::string tiles(const ReportData& data) {
  std::string html;
  if (const StudyRow* row = main_row(data.rows)) {
    const Evaluation& observer = row->observer().first();
    const ErrorMetrics& own = observer.metrics;
    html += tile(significant(own.norm),
                 fmt::format("{}error norm, {}", own.normalised ? "normalised " : "", noise_title(observer.noise)));
    if (own.settled) html += tile(significant(*own.settled), settled_text(own));
    if (own.settling_time_s) html += tile(fmt::format("{} s", fixed(*own.settling_time_s, 1)), "settling time");
  }
  if (data.logs) {
    const LogMetrics& own = data.logs->entries.front().metrics;
    const std::size_t settled = settled_window(own.windows);
    for (const StateError& state : own.pooled)
      html += tile(fmt::format("{} {}", significant(state.rmse[settled]), state.unit),
                   fmt::format("{}, {}, {} logs", state.name, window_text(own.windows[settled]),
                               data.logs->split.empty() || data.logs->split == "test" ? "unseen" : data.logs->split));
  }
  if (data.control_loop) {
    html += tile(nanoseconds(data.control_loop->step_and_estimate.p50), "step + estimate, median");
    html += tile(fmt::format("{} of {}", data.control_loop->missed_deadlines, data.control_loop->ticks),
                 "deadlines missed");
  }
  return html.empty() ? "" : fmt::format("<div class=\"tiles\">\n{}</div>\n", html);
}

}  // namespace nlo::trainer
