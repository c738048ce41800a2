// SPDX-License-Identifier: MIT
// The strict test of models on new trajectories of their own plant, by the experiment that they carry, beside what a
// user would do without them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"
#include "trainer/judge/compare/conditions.h"
#include "trainer/judge/evaluation/evaluate.h"
#include "trainer/judge/evaluation/evaluation_study.h"
#include "trainer/judge/evaluation/metrics.h"

namespace nlo::trainer {

struct StrictTest {
  std::vector<Condition> conditions;
  std::vector<std::string> against;  ///< of alternative_names(), or kTrueEkf; constant and ridge are always there
  unsigned long long seed = 1;       ///< of the initial states and the noise
  int trajectories = 200;
  int threads = 0;    ///< 0: all cores
  int test_sets = 1;  ///< by the seeds seed, seed + 1, ...
};

/// Those of `noises` in a plant as it is.
std::vector<Condition> conditions_of(const std::vector<NoiseConfig>& noises, const Condition& common = {});

/// The EKF that knows what the condition's `changes` have made of the plant.
inline constexpr std::string_view kTrueEkf = "ekf_true";

/// What --against takes beside it: the filters of filter_table() and simple_names().
std::vector<std::string> alternative_names();

/// Per condition the observers and then their alternatives. Models must come from `experiment`, whatever their seeds.
///   ekf, ...  filters know the plant that the models were trained for: with changes, wrong parameters
///   ekf_true  knows the plant that it is tested on
///   constant  the mean state of new runs of the plant that the models were trained for
///   ridge     the linear readout of each model's features, fitted on those runs under the condition's noise
/// Throws codegen::Error when a trajectory leaves the numbers.
std::vector<EvaluationStudy> run_strict_study(const std::vector<NamedModel>& models, const Experiment& experiment,
                                              const StrictTest& test, const StudyProgress& progress = {});

/// The same of one model on one test set: per condition the observer and then its alternatives.
std::vector<std::vector<Evaluation>> run_strict_test(const codegen::Model& model, const Experiment& experiment,
                                                     const StrictTest& test);

}  // namespace nlo::trainer
