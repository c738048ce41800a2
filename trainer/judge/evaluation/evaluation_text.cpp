// SPDX-License-Identifier: MIT
#include "trainer/judge/evaluation/evaluation_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "trainer/base/number_text.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {
namespace {

std::string domain_line(const DomainShare& domain, const char* runs) {
  if (domain.runs == 0) return "";
  return fmt::format("\n  in domain: {} of the samples; {} of {} first samples of {}\n", percent(domain.share()),
                     domain.first_inside, domain.runs, runs);
}

std::string shown_name(const Evaluation& evaluation) {
  return evaluation.label.empty() ? evaluation.estimator : evaluation.label;
}

/// A row per state for each estimator with intervals. The text is empty if no estimator has any.
class CoverageTable {
 public:
  void add(const std::string& estimator, const std::vector<Channel>& states, const std::optional<Coverage>& coverage) {
    if (!coverage) return;
    if (!table_.rows.empty()) table_.add_rule();
    for (std::size_t i = 0; i < states.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      table_.add_row({fmt::format("{}, {}", with_unit(states[i].name, states[i].unit), estimator),
                      fmt::format("{:.1f} %", 100.0 * coverage->share_68(row)),
                      fmt::format("{:.1f} %", 100.0 * coverage->share_95(row)), significant(coverage->sigma(row)),
                      fmt::format("{:.1f} %", 100.0 * coverage->unknown(row))});
    }
  }
  std::string text() const { return table_.rows.empty() ? "" : "\n" + table_.to_text(2); }

 private:
  Table table_{{"truth within the interval of", "68 %", "95 %", "mean half width of 68 %", "no interval"}};
};

std::string what_was_tested(const StudyRow& row, const std::string& note) {
  const Evaluation& first = row.observer().first();
  const std::size_t sets = row.observer().test_sets(), models = row.models.size();
  std::string text = models == 1 ? row.models.front() : fmt::format("{} models of one experiment", models);
  if (sets > 1) text += fmt::format(" on {} test sets", sets);
  text += fmt::format("{} {} trajectories of {} s, noise {}, ", sets > 1 ? " of" : " on", first.trajectories,
                      shortest_text(first.horizon_s), format_noise(first.noise));
  text +=
      sets > 1 ? fmt::format("seeds {} to {}", first.seed, first.seed + sets - 1) : fmt::format("seed {}", first.seed);
  for (const auto& [input, expression] : first.excitation) text += fmt::format(", {} = {}", input, expression);
  if (!first.changed.empty()) text += fmt::format(", changed: {}", first.changed);
  if (!note.empty()) text += ", " + note;
  text += "\n";
  if (models > 1) text += fmt::format("models: {}\n", fmt::join(row.models, ", "));
  if (!row.observer().is_single())
    text += fmt::format("mean ± standard error over {}{}{}\n", sets > 1 ? "test sets" : "",
                        sets > 1 && models > 1 ? " ± standard error over " : "", models > 1 ? "training seeds" : "");
  if (first.metrics.normalised)
    text += "The states' units differ, so norms use each state divided by its standard deviation in the test set.\n";
  return text + "\n";
}

std::string notes_text(const std::vector<std::string>& notes) {
  std::string text;
  for (const std::string& note : notes) text += fmt::format("\n  note: {}\n", note);
  return text;
}

}  // namespace

Table evaluation_table(std::span<const StudyRow> rows, bool is_headed) {
  const Evaluation& first = rows.front().observer().first();
  std::vector<std::pair<std::string, Quantity>> columns = {
      {first.metrics.normalised ? "normalised norm" : "norm",
       [](const ErrorMetrics& m) { return std::optional(m.norm); }},
      {"nrmse", [](const ErrorMetrics& m) { return m.nrmse; }}};
  const auto add_where_defined = [&](const std::string& heading, const Quantity& value, const Quantity& shown) {
    for (const StudyRow& row : rows)
      for (const StudyCell& cell : row.cells)
        if (shown(cell.first().metrics)) return columns.emplace_back(heading, value), void();
  };
  for (std::size_t w = 1; w < first.metrics.windows.size(); ++w) {
    const Quantity norm = [w](const ErrorMetrics& m) { return m.windows[w].norm; };
    add_where_defined(window_text(first.metrics.windows[w].window), norm, norm);
  }
  const std::size_t settling = columns.size();
  add_where_defined(
      "settling time [s]", [](const ErrorMetrics& m) { return m.settling_time_s; },
      [](const ErrorMetrics& m) { return m.settling_time_s ? m.settling_time_s : m.settled; });
  for (std::size_t i = 0; i < first.states.size(); ++i)
    columns.emplace_back("RMSE " + with_unit(first.states[i].name, first.states[i].unit), [i](const ErrorMetrics& m) {
      return std::optional(m.per_component[static_cast<Eigen::Index>(i)]);
    });
  Table table{{""}};
  for (const auto& column : columns) table.headings.push_back(column.first);
  for (const StudyRow& row : rows) {
    const Evaluation& own = row.observer().first();
    if (is_headed)
      table.add_row({fmt::format("{}: {} runs of {} s, seed {}", noise_title(own.noise), own.trajectories,
                                 significant(own.horizon_s, 2), own.seed)});
    for (const StudyCell& cell : row.cells) {
      table.add_row({shown_name(cell.first())});
      for (std::size_t c = 0; c < columns.size(); ++c) {
        const auto spread = spread_of(cell, columns[c].second);
        const bool never = c == settling && cell.first().metrics.settled;
        table.rows.back().push_back(spread ? to_text(*spread) : never ? "never" : "-");
      }
    }
  }
  return table;
}

std::string evaluation_text(const StudyRow& row, const std::string& note) {
  CoverageTable coverage;
  for (const StudyCell& cell : row.cells)
    coverage.add(shown_name(cell.first()), cell.first().states, study_coverage(cell));
  return what_was_tested(row, note) + evaluation_table(std::span(&row, 1)).to_text(2) + coverage.text() +
         domain_line(study_domain(row.observer()), "a trajectory") + notes_text(study_notes(row));
}

Table log_table(const std::vector<LogEntry>& entries, bool with_cost) {
  const LogMetrics& first = entries.front().metrics;
  Table table{{"RMSE"}};
  for (const EvaluationWindow& window : first.windows) table.headings.push_back(window_text(window));
  if (with_cost) table.headings.insert(table.headings.end(), {"operations", "functions"});
  for (std::size_t i = 0; i < first.pooled.size(); ++i) {
    table.add_row({with_unit(first.pooled[i].name, first.pooled[i].unit)});
    for (const LogEntry& entry : entries) {
      const StateError& state = entry.metrics.pooled[i];
      // Skips a baseline that does not apply to this state.
      if (!entry.describe.empty() && !std::isfinite(state.rmse[0])) continue;
      const bool described = i < entry.describe.size() && !entry.describe[i].empty();
      table.add_row({described ? entry.describe[i] : entry.estimator});
      auto& row = table.rows.back();
      for (const double error : state.rmse) row.push_back(significant(error));
      if (with_cost && entry.cost.operations > 0.0)
        row.insert(row.end(), {fixed(entry.cost.operations, 0), fixed(entry.cost.functions, 0)});
    }
  }
  return table;
}

Table file_table(const LogEvaluation& evaluation) {
  const LogMetrics& observer = evaluation.entries.front().metrics;
  Table table{{"observer, for each file"}};
  if (observer.files.size() < 2) return table;
  std::vector<std::size_t> shown = {0};
  if (const std::size_t settled = settled_window(observer.windows); settled > 0) shown.push_back(settled);
  for (const StateError& state : observer.pooled)
    for (const std::size_t window : shown)
      table.headings.push_back(with_unit(state.name, state.unit) + ", " + observer.windows[window].name);
  for (const LogMetrics::File& file : observer.files) {
    table.add_row({file.source});
    for (const StateError& state : file.states)
      for (const std::size_t window : shown) table.rows.back().push_back(significant(state.rmse[window]));
  }
  return table;
}

std::string evaluation_text(const std::string& model, const LogEvaluation& evaluation) {
  const LogMetrics& observer = evaluation.entries.front().metrics;
  std::string text = fmt::format(
      "{} on {} {}{}, {}noise added: {}{} (alternatives fitted on {})\n\n", model, observer.files.size(),
      observer.files.size() == 1 ? "log" : "logs", evaluation.behind_gate ? " behind its monitor's gate" : "",
      evaluation.missing.empty() ? "" : fmt::format("without {}, ", fmt::join(evaluation.missing, ", ")),
      format_noise(evaluation.noise), evaluation.noise.none() ? "" : fmt::format(", seed {}", evaluation.seed),
      evaluation.baselines_fitted_on);
  CoverageTable coverage;
  coverage.add("observer", evaluation.states, evaluation.coverage);
  coverage.add("widened by its monitor", evaluation.states, evaluation.widened_coverage);
  text += log_table(evaluation.entries).to_text(2) + coverage.text();
  if (const Table files = file_table(evaluation); !files.rows.empty()) text += "\n" + files.to_text(2);
  if (evaluation.unscored.share > 0.0)
    text += fmt::format("\n  unscored: {} of the samples, {}\n", percent(evaluation.unscored.share),
                        evaluation.unscored.where);
  if (!evaluation.unscored_states.empty())
    text += fmt::format(
        "\n  unscored: {}, because these logs have no truth for them (--estimates FILE.csv writes their estimates)\n",
        fmt::join(evaluation.unscored_states, ", "));
  return text + domain_line(evaluation.domain, "a log") + notes_text(evaluation.notes);
}

}  // namespace nlo::trainer
