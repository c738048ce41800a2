// SPDX-License-Identifier: MIT
#include "trainer/evaluation/evaluation_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "trainer/base/number_text.h"
#include "trainer/evaluation/text.h"

namespace nlo::trainer {
namespace {

std::string with_unit(const std::string& name, const std::string& unit) {
  return unit.empty() ? name : fmt::format("{} [{}]", name, unit);
}

std::string rmse(double value) {
  return std::isfinite(value) ? significant(value) : "-";
}

/// As many digits as the mean is shown with.
std::string cell(const std::optional<Spread>& spread, const char* missing = "-") {
  if (!spread) return missing;
  if (!spread->test_set_error && !spread->training_seed_error) return significant(spread->mean);
  std::string text = significant(spread->mean, 4);
  if (spread->test_set_error) text += " ± " + significant(*spread->test_set_error, 2);
  if (spread->training_seed_error) text += " ± " + significant(*spread->training_seed_error, 2);
  return text;
}

/// "one of 2,501": whole shares without a point.
std::string percent(double share) {
  return fmt::format("{} %", share == 1.0 ? "100" : significant(100.0 * share, share > 0.99 ? 4 : 3));
}

std::string domain_line(const DomainShare& domain, const char* runs) {
  if (domain.runs == 0) return "";
  return fmt::format("\n  in domain: {} of the samples; {} of {} first samples of {}\n", percent(domain.share()),
                     domain.first_inside, domain.runs, runs);
}

/// A row per state for each estimator that knows how wrong it is; nothing when none does.
class CoverageTable {
 public:
  void add(const std::string& estimator, const std::vector<Channel>& states, const std::optional<Coverage>& coverage) {
    if (!coverage) return;
    if (!table_.empty()) table_.add_rule();
    for (std::size_t i = 0; i < states.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      table_.add_row({fmt::format("{}, {}", with_unit(states[i].name, states[i].unit), estimator),
                      fmt::format("{:.1f} %", 100.0 * coverage->share_68(row)),
                      fmt::format("{:.1f} %", 100.0 * coverage->share_95(row)), significant(coverage->sigma(row))});
    }
  }
  std::string text() const { return table_.empty() ? "" : "\n" + table_.to_string(2); }

 private:
  TextTable table_{{"truth within the interval of", "68 %", "95 %", "mean half width of 68 %"}};
};

std::string what_was_tested(const EvaluationStudy& study, const std::string& note) {
  const Evaluation& first = study.first().front();
  const std::size_t sets = study.test_sets(), models = study.models.size();
  std::string text =
      study.models.size() == 1 ? study.models.front() : fmt::format("{} models of one experiment", study.models.size());
  if (sets > 1) text += fmt::format(" on {} test sets", sets);
  text += fmt::format("{} {} trajectories of {} s, noise {}, ", sets > 1 ? " of" : " on", first.trajectories,
                      shortest_text(first.horizon_s), format_noise(first.noise));
  text +=
      sets > 1 ? fmt::format("seeds {} to {}", first.seed, first.seed + sets - 1) : fmt::format("seed {}", first.seed);
  for (const auto& [input, expression] : first.excitation) text += fmt::format(", {} = {}", input, expression);
  if (!first.changed.empty()) text += fmt::format(", changed: {}", first.changed);
  if (!note.empty()) text += ", " + note;
  text += "\n";
  if (models > 1) text += fmt::format("models: {}\n", fmt::join(study.models, ", "));
  if (!study.is_single())
    text += fmt::format("mean ± standard error over {}{}{}\n", sets > 1 ? "test sets" : "",
                        sets > 1 && models > 1 ? " ± standard error over " : "", models > 1 ? "training seeds" : "");
  if (first.metrics.normalised)
    text += "The states' units differ: norms are of each state over its standard deviation in the test set.\n";
  return text + "\n";
}

std::string notes_text(const std::vector<std::string>& notes) {
  std::string text;
  for (const std::string& note : notes) text += fmt::format("\n  note: {}\n", note);
  return text;
}

}  // namespace

std::string evaluation_text(const EvaluationStudy& study, const std::string& note) {
  const std::vector<Evaluation>& evaluations = study.first();
  const Evaluation& first = evaluations.front();
  const char* norm = first.metrics.normalised ? "normalised norm" : "norm";
  std::vector<std::string> headings = {"", norm, "nrmse"};
  std::vector<Quantity> quantities = {[](const ErrorMetrics& m) { return std::optional(m.norm); },
                                      [](const ErrorMetrics& m) { return m.nrmse; }};
  for (std::size_t w = 1; w < first.metrics.windows.size(); ++w) {
    headings.push_back(window_text(first.metrics.windows[w].window));
    quantities.emplace_back([w](const ErrorMetrics& m) { return m.windows[w].norm; });
  }
  headings.emplace_back("settling time [s]");
  quantities.emplace_back([](const ErrorMetrics& m) { return m.settling_time_s; });
  const std::size_t settling = quantities.size() - 1;
  for (std::size_t i = 0; i < first.states.size(); ++i) {
    headings.push_back(fmt::format("RMSE {}", with_unit(first.states[i].name, first.states[i].unit)));
    quantities.emplace_back(
        [i](const ErrorMetrics& m) { return std::optional(m.per_component[static_cast<Eigen::Index>(i)]); });
  }
  TextTable table(std::move(headings));
  for (std::size_t e = 0; e < evaluations.size(); ++e) {
    const Evaluation& row = evaluations[e];
    std::vector<std::string> cells = {row.label.empty() ? row.estimator : row.label};
    for (std::size_t q = 0; q < quantities.size(); ++q)
      cells.push_back(cell(spread_of(study, e, quantities[q]), q == settling && row.metrics.settled ? "never" : "-"));
    table.add_row(std::move(cells));
  }
  CoverageTable coverage;
  for (std::size_t e = 0; e < evaluations.size(); ++e)
    coverage.add(evaluations[e].label.empty() ? evaluations[e].estimator : evaluations[e].label, first.states,
                 study_coverage(study, e));
  return what_was_tested(study, note) + table.to_string(2) + coverage.text() +
         domain_line(study_domain(study), "a trajectory") + notes_text(study_notes(study));
}

std::string evaluation_text(const std::string& model, const std::vector<Evaluation>& evaluations,
                            const std::string& note) {
  return evaluations.empty() ? "" : evaluation_text(EvaluationStudy{{model}, {{evaluations}}}, note);
}

std::string evaluation_text(const std::string& model, const LogEvaluation& evaluation) {
  const LogMetrics& observer = evaluation.entries.front().metrics;
  std::string text = fmt::format(
      "{} on {} {}, {}noise added: {}{} (alternatives fitted on {})\n\n", model, observer.files.size(),
      observer.files.size() == 1 ? "log" : "logs",
      evaluation.missing.empty() ? "" : fmt::format("without {}, ", fmt::join(evaluation.missing, ", ")),
      format_noise(evaluation.noise), evaluation.noise.none() ? "" : fmt::format(", seed {}", evaluation.seed),
      evaluation.baselines_fitted_on);

  std::vector<std::string> headings = {"RMSE"};
  for (const EvaluationWindow& window : observer.windows) headings.push_back(window_text(window));
  TextTable table(std::move(headings));
  for (std::size_t i = 0; i < observer.pooled.size(); ++i) {
    if (i > 0) table.add_rule();
    for (const auto& entry : evaluation.entries) {
      const StateError& state = entry.metrics.pooled[i];
      const bool ours = &entry == &evaluation.entries.front();
      const bool described = !ours && i < entry.describe.size() && !entry.describe[i].empty();
      if (!ours && !std::isfinite(state.rmse[0])) continue;  // this baseline does not apply to a hidden state
      const std::string& name = described ? entry.describe[i] : entry.estimator;
      std::vector<std::string> row = {ours ? fmt::format("{}, {}", with_unit(state.name, state.unit), name)
                                           : fmt::format("  {}", name)};
      for (const double error : state.rmse) row.push_back(rmse(error));
      table.add_row(std::move(row));
    }
  }
  CoverageTable coverage;
  coverage.add("observer", evaluation.states, evaluation.coverage);
  text += table.to_string(2) + coverage.text();

  if (observer.files.size() > 1) {
    const std::size_t settled = settled_window(observer.windows);
    std::vector<std::size_t> shown = {0};
    if (settled > 0) shown.push_back(settled);
    std::vector<std::string> names = {"observer, file by file"};
    for (const StateError& state : observer.pooled)
      for (const std::size_t window : shown)
        names.push_back(fmt::format("{} {}", with_unit(state.name, state.unit), observer.windows[window].name));
    TextTable files(std::move(names));
    for (const LogMetrics::File& file : observer.files) {
      std::vector<std::string> row = {file.source};
      for (const StateError& state : file.states)
        for (const std::size_t window : shown) row.push_back(rmse(state.rmse[window]));
      files.add_row(std::move(row));
    }
    text += fmt::format("\n{}", files.to_string(2));
  }
  if (evaluation.unscored.share > 0.0)
    text += fmt::format("\n  unscored: {} of the samples, {}\n", percent(evaluation.unscored.share),
                        evaluation.unscored.where);
  if (!evaluation.unscored_states.empty())
    text +=
        fmt::format("\n  unscored: {}, of which these logs have no truth (--estimates FILE.csv has their estimates)\n",
                    fmt::join(evaluation.unscored_states, ", "));
  return text + domain_line(evaluation.domain, "a log") + notes_text(evaluation.notes);
}

}  // namespace nlo::trainer
