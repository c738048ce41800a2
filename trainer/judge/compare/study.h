// SPDX-License-Identifier: MIT
// Evaluates estimators under conditions on test sets, for nlo evaluate, nlo report and the strict test.
#pragma once

#include <atomic>
#include <string>
#include <string_view>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/judge/compare/conditions.h"
#include "trainer/judge/evaluation/evaluate.h"
#include "trainer/judge/evaluation/evaluation_study.h"

namespace nlo::trainer {

/// The EKF that knows the plant with a condition's `changes`.
inline constexpr std::string_view kTrueEkf = "ekf_true";

/// The floor: the particle filter that knows each condition.
inline constexpr std::string_view kParticle = "particle";

struct StudyTest {
  std::vector<Condition> conditions;
  std::vector<std::string> against;  ///< alternative_names(), kTrueEkf, kParticle
  unsigned long long seed = 1;       ///< seed of initial states and noise in the first test set; then seed + 1 ...
  int test_sets = 1;
  int trajectories = 200;  ///< number of trajectories in each test set
  int threads = 0;         ///< 0: all cores; the result does not depend on it

  /// If false, the plant is that of the training, with parameters and noise drawn as in training. Several models then
  /// count as one observer with several training seeds. A constant and the ridge regression of each model are always
  /// included. If true, the plant has its nominal parameters and the noise of the condition. Each model is then a
  /// separate observer, filters step all runs side by side, and the norms of all test sets have the same scale.
  bool by_condition = false;
  bool tune = false;  ///< by condition: adds each filter tuned for the condition
  /// Used by condition. If true, a condition under which the plant cannot be simulated (for example because of the
  /// square root of a negative level) is left out and listed in Study::impossible. If false, it is an error.
  bool leave_out_impossible = false;
  int tuning_trajectories = 16;
  int particles = 400;
};

/// An observer, a filter as shipped, a filter tuned for each condition, an estimator without a plant, or the floor.
struct StudyEstimator {
  std::string name;     ///< "observer" or the name of the model, "ekf", "ekf_tuned", ..., "particle"
  std::string meaning;  ///< in words
  bool is_observer = false;

  // Cost of one step and estimate of one run; 0 if an expression is unknown.
  double operations = 0.0, functions = 0.0;  ///< a multiply-add is two operations
  double state_bytes = 0.0;                  ///< state of a float implementation between samples
  double constant_bytes = 0.0;               ///< constants of a model

  static constexpr std::string_view kTuned = "_tuned";  ///< ending of the name of a tuned filter
  bool is_tuned() const { return !is_observer && name.ends_with(kTuned); }
  /// Returns the name without this ending: "ekf" for "ekf_tuned".
  std::string untuned_name() const { return name.substr(0, name.size() - (is_tuned() ? kTuned.size() : 0)); }
};

struct Study {
  std::string experiment, plant;
  StudyTest test;
  double horizon_s = 0.0;
  std::vector<std::string> left_out = {};    ///< conditions on parameters, for a plant without parameters
  std::vector<std::string> impossible = {};  ///< "NAME: reason" of each condition that cannot be simulated
  std::vector<StudyEstimator> estimators = {};
  std::vector<StudyRow> rows = {};  ///< one for each of test.conditions, with a cell for each estimator
  /// By condition: the run with the largest error of the first observer, with its readings.
  std::vector<EvaluatedRun> worst = {};
  std::size_t worst_row = 0;

  const StudyCell& cell(std::size_t condition, std::size_t estimator) const { return rows[condition].cells[estimator]; }
};

/// Returns the values of --against: the filters of filter_table() and simple_names().
std::vector<std::string> alternative_names();

/// Returns a condition for each of `noises`, with the rest of `common`.
std::vector<Condition> conditions_of(const std::vector<NoiseConfig>& noises, const Condition& common = {});

/// Returns the conditions of `set` in the units of the plant (conditions_of). Noises are scaled to the noise of the
/// experiment's training. Throws codegen::Error for a condition that the plant does not support.
///   left_out  gets the names of conditions on parameters if the plant has none
std::vector<Condition> compared_conditions(const Experiment& experiment, const ConditionSet& set,
                                           std::vector<std::string>& left_out);

/// Evaluates models of `experiment` and their alternatives under each condition, on each test set.
///   ekf, ...  filters that know the plant of the training; if the plant is changed, their parameters are wrong
///   ekf_true  knows the tested plant
///   constant  the mean state of new runs of the plant of the training
///   ridge     the linear readout of each model's features, fitted on those runs with the condition's noise
/// Throws codegen::Error if a trajectory is not finite, and if `stop` is set.
Study run_study(const std::vector<NamedModel>& models, const Experiment& experiment, const StudyTest& test,
                const StudyProgress& progress = {}, const std::atomic<bool>* stop = nullptr);

}  // namespace nlo::trainer
