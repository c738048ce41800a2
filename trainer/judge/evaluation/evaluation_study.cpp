// SPDX-License-Identifier: MIT
#include "trainer/judge/evaluation/evaluation_study.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {

std::optional<Spread> spread_of(const EvaluationStudy& study, std::size_t estimator, const Quantity& quantity) {
  Eigen::MatrixXd values(static_cast<Eigen::Index>(study.models.size()), static_cast<Eigen::Index>(study.test_sets()));
  for (Eigen::Index m = 0; m < values.rows(); ++m)
    for (Eigen::Index s = 0; s < values.cols(); ++s) {
      const auto& evaluations = study.results[static_cast<std::size_t>(m)][static_cast<std::size_t>(s)];
      const std::optional<double> value = quantity(evaluations.at(estimator).metrics);
      if (!value) return std::nullopt;
      values(m, s) = *value;
    }
  const Eigen::VectorXd by_test_set = values.colwise().mean(), by_model = values.rowwise().mean();
  return Spread{values.mean(), standard_error(std::span(by_test_set.data(), by_test_set.size())),
                standard_error(std::span(by_model.data(), by_model.size()))};
}

std::vector<std::string> study_notes(const EvaluationStudy& study) {
  const std::vector<Evaluation>& first = study.first();
  std::vector<ComparedState> compared;
  for (std::size_t i = 0; i < first.front().states.size(); ++i) {
    std::size_t window = 0;
    const auto error_of = [&](std::size_t estimator) {
      const auto spread = spread_of(study, estimator, [&](const ErrorMetrics& m) -> std::optional<double> {
        if (m.windows[window].per_component.size() == 0) return std::nullopt;
        return m.windows[window].per_component[static_cast<Eigen::Index>(i)];
      });
      return spread ? spread->mean : std::numeric_limits<double>::quiet_NaN();
    };
    EvaluationWindows windows;
    for (const ErrorMetrics::Window& w : first.front().metrics.windows) windows.push_back(w.window);
    window = settled_window(windows);
    if (!std::isfinite(error_of(0))) window = 0;  // runs that end before it
    ComparedState state{first.front().states[i].name,
                        first.front().states[i].unit,
                        window_text(windows[window]),
                        error_of(0),
                        std::numeric_limits<double>::quiet_NaN(),
                        std::numeric_limits<double>::quiet_NaN()};
    for (std::size_t e = 1; e < first.size(); ++e) {
      if (first[e].estimator == "constant") state.constant = error_of(e);
      if (first[e].estimator == "ridge") state.simple = error_of(e);
    }
    compared.push_back(std::move(state));
  }
  std::vector<std::string> notes = comparison_notes(compared);
  for (std::size_t e = 1; e < first.size(); ++e)
    if (const auto loop = study_loop(study, e))
      notes.push_back(first[e].label + ": " + to_text(*loop, first[e].states));
  return notes;
}

std::optional<ClosedLoopCost> study_loop(const EvaluationStudy& study, std::size_t estimator) {
  std::optional<ClosedLoopCost> sum;
  double loops = 0.0;
  for (const auto& by_test_set : study.results)
    for (const auto& evaluations : by_test_set) {
      const std::optional<ClosedLoopCost>& one = evaluations.at(estimator).loop;
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

std::optional<Coverage> study_coverage(const EvaluationStudy& study, std::size_t estimator) {
  std::vector<std::optional<Coverage>> all;
  for (const auto& by_test_set : study.results)
    for (const auto& evaluations : by_test_set) all.push_back(evaluations.at(estimator).coverage);
  return mean_coverage(all);
}

DomainShare study_domain(const EvaluationStudy& study) {
  DomainShare sum;
  for (const auto& by_test_set : study.results)
    for (const auto& evaluations : by_test_set) {
      if (!evaluations.front().domain) continue;
      const DomainShare& share = *evaluations.front().domain;
      sum.samples += share.samples;
      sum.inside += share.inside;
      sum.runs += share.runs;
      sum.first_inside += share.first_inside;
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
          fmt::format("{} is not seen: its error, {}: {}, is no better than that of a constant, {}. These "
                      "outputs may not determine it.",
                      state.name, state.window, shown(state.observer), shown(state.constant)));
    else if (is_no_better_than(state.simple))
      notes.push_back(fmt::format("{} needs no network: its error, {}: {}, is no better than that of {}, {}.",
                                  state.name, state.window, shown(state.observer), state.simple_name,
                                  shown(state.simple)));
  }
  return notes;
}

}  // namespace nlo::trainer
