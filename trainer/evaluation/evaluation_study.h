// SPDX-License-Identifier: MIT
// One row of a test over several test sets and several trained models: means with their standard errors. One test set
// is one draw: on Van der Pol the norms of single sets scatter by more than the differences between observers.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "trainer/evaluation/evaluate.h"
#include "trainer/evaluation/text.h"

namespace nlo::trainer {

/// Evaluations under one noise. Models of one experiment differ in their training seed alone.
struct EvaluationStudy {
  std::vector<std::string> models;
  /// By model, then by test set; in each the observer first, then its alternatives in the same order.
  std::vector<std::vector<std::vector<Evaluation>>> results;

  const std::vector<Evaluation>& first() const { return results.front().front(); }
  std::size_t test_sets() const { return results.front().size(); }
  bool is_single() const { return models.size() == 1 && test_sets() == 1; }
};

/// A number of an evaluation; empty where it is not defined.
using Quantity = std::function<std::optional<double>(const ErrorMetrics&)>;

/// Mean over models and test sets of the estimator at place `estimator` of each list. Empty when one of the evaluations
/// does not define the quantity: the mean of those that do would flatter.
std::optional<Spread> spread_of(const EvaluationStudy& study, std::size_t estimator, const Quantity& quantity);

/// Notes of comparison.h on the observer's mean errors in the settled window; needs the estimators "constant" and
/// "ridge"; and of each loop what it costs.
std::vector<std::string> study_notes(const EvaluationStudy& study);

/// What the loop of an estimator costs over all models and test sets; empty where it is in none.
std::optional<ClosedLoopCost> study_loop(const EvaluationStudy& study, std::size_t estimator);

/// The mean coverage of an estimator; empty where it does not know how wrong it is.
std::optional<Coverage> study_coverage(const EvaluationStudy& study, std::size_t estimator);

/// The observer's domain over all models and test sets.
DomainShare study_domain(const EvaluationStudy& study);

}  // namespace nlo::trainer
