// SPDX-License-Identifier: MIT
// What the candidates of a search are judged by: whole runs from the first sample, as they fly, that neither training
// nor any test has seen.
#pragma once

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/evaluation/metrics.h"

namespace nlo::trainer {

class SearchJudge {
 public:
  /// `validation`: of an experiment with logs; one with a plant gets runs of its own.
  SearchJudge(const Experiment& experiment, const Dataset& validation);

  /// The norm under the noise of the training, of a mixture the mean over its parts; over states whose units differ, or
  /// whose loss is normalised, of states over their deviation. Throws codegen::Error where an estimate is no number.
  double error(const codegen::Model& model) const;

 private:
  const Experiment& experiment_;
  Dataset runs_;
  MetricsConfig config_;
};

}  // namespace nlo::trainer
