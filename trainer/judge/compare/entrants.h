// SPDX-License-Identifier: MIT
// Who takes part in a study: what each estimator is made of, what it is called,
// and what a step of it costs.
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
  std::vector<const NamedModel*> models = {};  ///< that it reads: one, or all of several training seeds
  bool knows_changes = false,
       in_loop = false;  ///< in_loop: its own estimates close the loop of [feedback]
};

/// The observer, what `test` wants, the constant and the ridge regression.
///   is_looped  then come those that close the loop: the observer and the
///   filters
std::vector<Entrant> strict_entrants(const std::vector<NamedModel>& models, const StudyTest& test, bool is_looped);

/// The observers, then of what `test` wants: filters as shipped and tuned, what
/// knows no plant, the floor.
///   nominal           the experiment with its nominal parameters
///   joint_parameters  that filters of state and parameters estimate
std::vector<Entrant> compared_entrants(const std::vector<NamedModel>& models, const Experiment& nominal,
                                       const std::vector<std::string>& joint_parameters, const StudyTest& test);

}  // namespace nlo::trainer
