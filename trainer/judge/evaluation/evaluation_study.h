// SPDX-License-Identifier: MIT
// Results of estimators under one condition: means over several test sets and several trained models, with their
// standard errors. One test set is not enough: on Van der Pol the norms of single sets scatter by more than the
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
  /// By model, then by test set. Models of one experiment differ only in their training seed.
  std::vector<std::vector<Evaluation>> evaluations = {};
  std::string missing = {};  ///< reason if there are no evaluations; else empty
  std::string tuning = {};   ///< tuning of a filter, in words
  int restarts = 0;          ///< number of runs that overflowed and were restarted

  const Evaluation& first() const { return evaluations.front().front(); }
  Evaluation& first() { return evaluations.front().front(); }
  std::size_t models() const { return evaluations.size(); }
  std::size_t test_sets() const { return evaluations.front().size(); }
  bool is_single() const { return models() == 1 && test_sets() == 1; }
};

/// All estimators under one condition.
struct StudyRow {
  std::vector<std::string> models;
  std::vector<StudyCell> cells;  ///< all estimators: an observer first, then its alternatives

  const StudyCell& observer() const { return cells.front(); }
};

/// Returns a number of an evaluation; nothing if it is not defined.
using Quantity = std::function<std::optional<double>(const ErrorMetrics&)>;

/// Returns the mean over models and test sets. Returns nothing if one evaluation does not define the quantity, because
/// a mean of the others would be too good.
std::optional<Spread> spread_of(const StudyCell& cell, const Quantity& quantity);

/// Returns the norm of the error over all samples.
Spread norm_of(const StudyCell& cell);

/// The run of the first model with the largest norm.
struct WorstRun {
  double norm = 0.0;
  std::size_t set = 0, run = 0;  ///< number of the test set, and of the run in it
};
WorstRun worst_run(const StudyCell& cell);

/// Returns notes (comparison_notes) on the observer's mean errors in the settled window, and the cost of each loop.
/// Needs the estimators "constant" and "ridge".
std::vector<std::string> study_notes(const StudyRow& row);

/// Returns the cost of an estimator's loop over all models and test sets; nothing if it closes no loop.
std::optional<ClosedLoopCost> study_loop(const StudyCell& cell);

/// Returns the mean coverage of an estimator; nothing if it has no intervals.
std::optional<Coverage> study_coverage(const StudyCell& cell);

/// Returns the observer's domain over all models and test sets.
DomainShare study_domain(const StudyCell& observer);

/// If the observer's error exceeds this share of another estimator's error, it does not estimate the state better.
inline constexpr double kNoBetterThanConstant = 0.95;

/// Errors of one state in one window; NaN without an error.
struct ComparedState {
  std::string name, unit;
  std::string window;                 ///< in words: "settled (t >= 10 s)"
  double observer, constant, simple;  ///< simple: error of the best other simple estimator, such as a linear readout
  std::string simple_name = "a ridge regression on the same features";
};

/// Returns a note for each state that is not observed, and for each that a simple estimator estimates as well. Empty if
/// there is none.
std::vector<std::string> comparison_notes(const std::vector<ComparedState>& states);

}  // namespace nlo::trainer
