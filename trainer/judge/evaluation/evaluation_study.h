// SPDX-License-Identifier: MIT
// Results of estimators under one condition: means over several test sets and several trained models, with their
// standard errors. One test set is one draw: on Van der Pol the norms of single sets scatter by more than the
// differences between observers. Notes compare the observer's errors with a constant and with the best simple
// estimator, for plants and logs.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "trainer/judge/evaluation/evaluate.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {

/// One estimator under one condition.
struct StudyCell {
  /// By model, then by test set. Models of one experiment differ in their training seed alone.
  std::vector<std::vector<Evaluation>> evaluations = {};
  std::string missing = {};  ///< why there are no evaluations; else empty
  std::string tuning = {};   ///< tuning of a filter, in words
  int restarts = 0;          ///< runs that left the finite numbers and began anew

  const Evaluation& first() const { return evaluations.front().front(); }
  Evaluation& first() { return evaluations.front().front(); }
  std::size_t models() const { return evaluations.size(); }
  std::size_t test_sets() const { return evaluations.front().size(); }
  bool is_single() const { return models() == 1 && test_sets() == 1; }
};

/// All estimators under one condition.
struct StudyRow {
  std::vector<std::string> models;
  std::vector<StudyCell> cells;  ///< an observer first, then its alternatives

  const StudyCell& observer() const { return cells.front(); }
};

/// A number of an evaluation; empty where it is not defined.
using Quantity = std::function<std::optional<double>(const ErrorMetrics&)>;

/// Mean over models and test sets. Empty if one of the evaluations does not define the quantity, because a mean of the
/// others would be too good.
std::optional<Spread> spread_of(const StudyCell& cell, const Quantity& quantity);

/// The norm of the error, over all samples.
Spread norm_of(const StudyCell& cell);

/// The run of the first model with the largest norm.
struct WorstRun {
  double norm = 0.0;
  std::size_t set = 0, run = 0;  ///< number of the test set, and of the run in it
};
WorstRun worst_run(const StudyCell& cell);

/// Notes (comparison_notes) on the observer's mean errors in the settled window; needs the estimators "constant" and
/// "ridge". Also the cost of each loop.
std::vector<std::string> study_notes(const StudyRow& row);

/// Cost of an estimator's loop over all models and test sets; empty if it closes no loop.
std::optional<ClosedLoopCost> study_loop(const StudyCell& cell);

/// The mean coverage of an estimator; empty where it does not know how wrong it is.
std::optional<Coverage> study_coverage(const StudyCell& cell);

/// The observer's domain over all models and test sets.
DomainShare study_domain(const StudyCell& observer);

/// A state whose error exceeds this share of another estimator's is not estimated better by the observer.
inline constexpr double kNoBetterThanConstant = 0.95;

/// Errors of one state in one window; NaN where there is none.
struct ComparedState {
  std::string name, unit;
  std::string window;                 ///< in words: "settled (t >= 10 s)"
  double observer, constant, simple;  ///< simple: the best of the others, such as a linear readout
  std::string simple_name = "a ridge regression on the same features";
};

/// A note for each state that is not seen, and for each that something simple estimates as well. None is good news.
std::vector<std::string> comparison_notes(const std::vector<ComparedState>& states);

}  // namespace nlo::trainer
