// SPDX-License-Identifier: MIT
// Observers against filters that know the plant, under many conditions, on the same runs: the errors with their
// standard errors over test seeds, the worst runs, and what a step costs.
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"
#include "trainer/judge/compare/conditions.h"
#include "trainer/judge/evaluation/evaluate.h"
#include "trainer/judge/evaluation/text.h"
#include "trainer/judge/filters/sigma_point_filter.h"

namespace nlo::trainer {

struct CompareTest {
  std::vector<std::string> against;  ///< names of filter_table(), and "particle"
  unsigned long long seed = 1;       ///< the first of the test seeds
  int seeds = 20, trajectories = 5;
  bool tune = true;
  int tuning_trajectories = 16;
  int particles = 400;
  int threads = 0;  ///< 0: all cores; the figures do not depend on it
};

/// An observer, a filter as shipped, a filter tuned for each condition, or the floor.
struct CompareColumn {
  std::string name;     ///< "observer" or the model's, "ekf", "ekf_tuned", ..., "particle"
  std::string meaning;  ///< in words
  bool is_observer = false;

  // Per step and estimate of one run. Counted; empty where an expression is unknown.
  double operations = 0.0, functions = 0.0;  ///< a multiply-add is two operations
  double state_bytes = 0.0;                  ///< that a float implementation keeps between samples
  double constant_bytes = 0.0;               ///< of a model

  static constexpr std::string_view kTuned = "_tuned";  ///< ends the name of a filter that is tuned
  bool is_tuned() const { return !is_observer && name.ends_with(kTuned); }
  /// "ekf" of "ekf_tuned"; of all others the name.
  std::string untuned_name() const { return name.substr(0, name.size() - (is_tuned() ? kTuned.size() : 0)); }
};

struct CompareCell {
  Eigen::VectorXd norms;      ///< of each test seed: root of the mean of |x - x_hat|^2 over its runs and samples
  double worst = 0.0;         ///< the largest norm of a run
  std::size_t worst_run = 0;  ///< its number among all runs, seed by seed
  std::string tuning;         ///< of a tuned filter, in words
  std::string missing;        ///< why there is no figure; else empty
  int restarts = 0;           ///< runs that left the finite numbers and began anew

  double mean() const { return norms.mean(); }
  Spread spread() const {
    return {mean(), standard_error(std::span(norms.data(), norms.size()))};
  }  ///< over the test seeds
};

struct Comparison {
  std::string experiment, plant;
  CompareTest test;
  double horizon_s = 0.0;
  bool normalised = false;  ///< norms of states over their deviations
  std::vector<Channel> states, outputs;
  std::vector<Condition> conditions;
  std::vector<std::string> left_out;  ///< conditions that the plant has no parameters for
  std::vector<CompareColumn> columns;
  std::vector<std::vector<CompareCell>> cells;  ///< by condition, then by column
  std::vector<EvaluatedRun> worst;              ///< the run on which the first observer is furthest off, as it saw it
  std::size_t worst_condition = 0;

  const CompareCell& cell(std::size_t condition, std::size_t column) const { return cells[condition][column]; }
};

/// Models of one plant, sample period and box as `experiment` has them; filters know its nominal parameters. Throws
/// codegen::Error for a model that is not, for a condition that the plant does not know, and when `stop` is set.
Comparison run_comparison(const std::vector<NamedModel>& models, const Experiment& experiment,
                          const ConditionSet& conditions, const CompareTest& test, const StudyProgress& progress = {},
                          const std::atomic<bool>* stop = nullptr);

/// The conditions of run_comparison(), checked against the plant; throws as it does.
std::vector<Condition> compared_conditions(const Experiment& experiment, const ConditionSet& set,
                                           std::vector<std::string>& left_out);

}  // namespace nlo::trainer
