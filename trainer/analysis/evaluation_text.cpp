// SPDX-License-Identifier: MIT
#include "trainer/analysis/evaluation_text.h"

#include <fmt/format.h>

#include <cmath>

#include "trainer/analysis/text.h"
#include "trainer/number_text.h"

namespace nlo::trainer {
namespace {

std::string with_unit(const std::string& name, const std::string& unit) {
  return unit.empty() ? name : fmt::format("{} [{}]", name, unit);
}

std::string seconds(const std::optional<double>& value) {
  return value ? fixed(*value, 1) : "never";
}

std::string rmse(double value) {
  return std::isfinite(value) ? significant(value) : "-";
}

}  // namespace

std::string evaluation_text(const std::string& model, const std::vector<Evaluation>& evaluations,
                            const std::string& note) {
  if (evaluations.empty()) return "";
  const Evaluation& first = evaluations.front();
  std::string text = fmt::format("{} on {} trajectories of {} s, noise {}, seed {}", model, first.trajectories,
                                 shortest_text(first.horizon_s), format_noise(first.noise), first.seed);
  for (const auto& [input, expression] : first.excitation) text += fmt::format(", {} = {}", input, expression);
  text += fmt::format("{}{}\n\n", note.empty() ? "" : ", ", note);
  std::vector<std::string> headings = {"", "norm", "nrmse", "settled (t >= 10 s)", "settling time [s]"};
  for (const Channel& state : first.states)
    headings.push_back(fmt::format("RMSE {}", with_unit(state.name, state.unit)));
  TextTable table(std::move(headings));
  for (const Evaluation& evaluation : evaluations) {
    const ErrorMetrics& m = evaluation.metrics;
    std::vector<std::string> row = {evaluation.estimator, significant(m.norm), significant(m.nrmse),
                                    significant(m.settled), m.settled ? seconds(m.settling_time_s) : "-"};
    for (const double component : m.per_component) row.push_back(significant(component));
    table.add_row(std::move(row));
  }
  return text + table.to_string(2);
}

std::string evaluation_text(const std::string& model, const LogEvaluation& evaluation) {
  const LogMetrics& observer = evaluation.entries.front().metrics;
  std::string text = fmt::format(
      "{} on {} {}, noise added: {}{} (alternatives fitted on {})\n\n", model, observer.files.size(),
      observer.files.size() == 1 ? "log" : "logs", format_noise(evaluation.noise),
      evaluation.noise.none() ? "" : fmt::format(", seed {}", evaluation.seed), evaluation.baselines_fitted_on);

  TextTable table({"RMSE", "", kErrorWindows[0].name, kErrorWindows[1].name, kErrorWindows[2].name});
  for (std::size_t i = 0; i < observer.pooled.size(); ++i) {
    if (i > 0) table.add_rule();
    for (const auto& entry : evaluation.entries) {
      const StateError& state = entry.metrics.pooled[i];
      const bool ours = &entry == &evaluation.entries.front();
      const bool described = !ours && i < entry.describe.size() && !entry.describe[i].empty();
      if (!ours && !std::isfinite(state.rmse[0])) continue;  // this baseline does not apply to a hidden state
      table.add_row({ours ? with_unit(state.name, state.unit) : "", described ? entry.describe[i] : entry.estimator,
                     rmse(state.rmse[0]), rmse(state.rmse[1]), rmse(state.rmse[2])});
    }
  }
  text += table.to_string(2);

  if (observer.files.size() > 1) {
    std::vector<std::string> headings = {"observer, file by file"};
    for (const StateError& state : observer.pooled)
      for (const std::size_t window : {0U, 1U})
        headings.push_back(fmt::format("{} {}", with_unit(state.name, state.unit), kErrorWindows[window].name));
    TextTable files(std::move(headings));
    for (const LogMetrics::File& file : observer.files) {
      std::vector<std::string> row = {file.source};
      for (const StateError& state : file.states)
        for (const std::size_t window : {0U, 1U}) row.push_back(rmse(state.rmse[window]));
      files.add_row(std::move(row));
    }
    text += fmt::format("\n{}", files.to_string(2));
  }
  for (const std::string& note : evaluation.notes) text += fmt::format("\n  note: {}\n", note);
  return text;
}

}  // namespace nlo::trainer
