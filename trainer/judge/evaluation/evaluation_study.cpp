// SPDX-License-Identifier: MIT
#include "trainer/judge/evaluation/evaluation_study.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {

std::optional<Spread> spread_of(const StudyCell& cell, const Quantity& quantity) {
  Eigen::MatrixXd values(static_cast<Eigen::Index>(cell.models()), static_cast<Eigen::Index>(cell.test_sets()));
  for (Eigen::Index m = 0; m < values.rows(); ++m)
    for (Eigen::Index s = 0; s < values.cols(); ++s) {
      const auto& by_test_set = cell.evaluations[static_cast<std::size_t>(m)];
      const std::optional<double> value = quantity(by_test_set[static_cast<std::size_t>(s)].metrics);
      if (!value) return std::nullopt;
      values(m, s) = *value;
    }
  const Eigen::VectorXd by_test_set = values.colwise().mean(), by_model = values.rowwise().mean();
  const auto error_of = [](const Eigen::VectorXd& all) {
    return standard_error(std::span(all.data(), static_cast<std::size_t>(all.size())));
  };
  return Spread{values.mean(), error_of(by_test_set), error_of(by_model)};
}

Spread norm_of(const StudyCell& cell) {
  return spread_of(cell, [](const ErrorMetrics& metrics) { return std::optional(metrics.norm); }).value();
}

WorstRun worst_run(const StudyCell& cell) {
  WorstRun worst;
  const std::vector<Evaluation>& sets = cell.evaluations.front();
  for (std::size_t s = 0; s < sets.size(); ++s)
    if (sets[s].worst > worst.norm) worst = {sets[s].worst, s, sets[s].worst_run};
  return worst;
}

std::vector<std::string> study_notes(const StudyRow& row) {
  const Evaluation& first = row.observer().first();
  std::vector<ComparedState> compared;
  for (std::size_t i = 0; i < first.states.size(); ++i) {
    std::size_t window = 0;
    const auto error_of = [&](const StudyCell& cell) {
      const auto spread = spread_of(cell, [&](const ErrorMetrics& m) -> std::optional<double> {
        if (m.windows[window].per_component.size() == 0) return std::nullopt;
        return m.windows[window].per_component[static_cast<Eigen::Index>(i)];
      });
      return spread ? spread->mean : std::numeric_limits<double>::quiet_NaN();
    };
    EvaluationWindows windows;
    for (const ErrorMetrics::Window& w : first.metrics.windows) windows.push_back(w.window);
    window = settled_window(windows);
    // Runs that end before the window are compared as a whole.
    if (!std::isfinite(error_of(row.observer()))) window = 0;
    ComparedState state{first.states[i].name,
                        first.states[i].unit,
                        window_text(windows[window]),
                        error_of(row.observer()),
                        std::numeric_limits<double>::quiet_NaN(),
                        std::numeric_limits<double>::quiet_NaN()};
    for (const StudyCell& cell : row.cells) {
      if (cell.first().estimator == "constant") state.constant = error_of(cell);
      if (cell.first().estimator == "ridge") state.simple = error_of(cell);
    }
    compared.push_back(std::move(state));
  }
  std::vector<std::string> notes = comparison_notes(compared);
  for (const StudyCell& cell : row.cells)
    if (const auto loop = study_loop(cell)) notes.push_back(cell.first().label + ": " + to_text(*loop, first.states));
  return notes;
}

std::optional<ClosedLoopCost> study_loop(const StudyCell& cell) {
  std::optional<ClosedLoopCost> sum;
  double loops = 0.0;
  for (const auto& by_test_set : cell.evaluations)
    for (const Evaluation& evaluation : by_test_set) {
      const std::optional<ClosedLoopCost>& one = evaluation.loop;
      if (!one) return std::nullopt;
      loops += 1.0;
      if (!sum) {
        sum = one;
        sum->deviation = one->deviation.cwiseAbs2();
        continue;
      }
      sum->deviation += one->deviation.cwiseAbs2();
      sum->runs += one->runs;
      sum->left += one->left;
      if (sum->cost) *sum->cost += one->cost.value_or(0.0);
      if (sum->of_true_state) *sum->of_true_state += one->of_true_state.value_or(0.0);
    }
  if (!sum) return std::nullopt;
  sum->deviation = (sum->deviation / loops).cwiseSqrt();
  if (sum->cost) *sum->cost /= loops;
  if (sum->of_true_state) *sum->of_true_state /= loops;
  return sum;
}

std::optional<Coverage> study_coverage(const StudyCell& cell) {
  std::vector<std::optional<Coverage>> all;
  for (const auto& by_test_set : cell.evaluations)
    for (const Evaluation& evaluation : by_test_set) all.push_back(evaluation.coverage);
  return mean_coverage(all);
}

DomainShare study_domain(const StudyCell& observer) {
  DomainShare sum;
  for (const auto& by_test_set : observer.evaluations)
    for (const Evaluation& evaluation : by_test_set) {
      if (!evaluation.domain) continue;
      sum.samples += evaluation.domain->samples;
      sum.inside += evaluation.domain->inside;
      sum.runs += evaluation.domain->runs;
      sum.first_inside += evaluation.domain->first_inside;
    }
  return sum;
}

std::vector<std::string> comparison_notes(const std::vector<ComparedState>& states) {
  std::vector<std::string> notes;
  for (const ComparedState& state : states) {
    if (!std::isfinite(state.observer)) continue;
    const auto shown = [&](double error) { return significant(error) + (state.unit.empty() ? "" : " " + state.unit); };
    const auto is_no_better_than = [&](double other) {
      return std::isfinite(other) && state.observer >= kNoBetterThanConstant * other;
    };
    if (is_no_better_than(state.constant))
      notes.push_back(
          fmt::format("{} is not observed: its error in the window {} is {}, not clearly below that of a constant, {}. "
                      "These outputs may not determine it.",
                      state.name, state.window, shown(state.observer), shown(state.constant)));
    else if (is_no_better_than(state.simple))
      notes.push_back(
          fmt::format("{} does not need a network: its error in the window {} is {}, not clearly below that of {}, {}.",
                      state.name, state.window, shown(state.observer), state.simple_name, shown(state.simple)));
  }
  return notes;
}

}  // namespace nlo::trainer
