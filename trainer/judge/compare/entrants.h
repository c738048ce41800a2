// SPDX-License-Identifier: MIT
// The estimators of a study: their origin, their names and the cost of a step.
#pragma once

#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/judge/compare/study.h"
#include "trainer/judge/evaluation/evaluate.h"

namespace nlo::trainer {

struct Entrant {
  enum class Kind { kObserver, kFilter, kSimple, kFloor };

  Kind kind = Kind::kObserver;
  StudyEstimator column;
  std::string made_of = {};                    ///< name in filter_table() or simple_names(): "ekf" of "ekf_true"
  std::vector<const NamedModel*> models = {};  ///< models that it reads: one, or one for each training seed
  bool knows_changes = false;                  ///< true: it knows the changed plant
  bool in_loop = false;                        ///< true: its own estimates close the loop of [feedback]
};

/// Returns the observer, the estimators of `test`, the constant and the ridge regression.
///   is_looped  adds the observer and the filters that close the loop themselves
std::vector<Entrant> strict_entrants(const std::vector<NamedModel>& models, const StudyTest& test, bool is_looped);

/// Returns the observers, then the estimators of `test`: filters as shipped and tuned, estimators without a plant, and
/// the floor (the particle filter that knows each condition).
///   nominal           the experiment with its nominal parameters
///   joint_parameters  parameters that joint filters estimate
std::vector<Entrant> compared_entrants(const std::vector<NamedModel>& models, const Experiment& nominal,
                                       const std::vector<std::string>& joint_parameters, const StudyTest& test);

}  // namespace nlo::trainer
