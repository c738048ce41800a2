// SPDX-License-Identifier: MIT
// The data of nlo train --auto, on which its candidates are trained and chosen.
#pragma once

#include <optional>
#include <string>

#include "codegen/model/model.h"
#include "trainer/app/commands/run_data.h"
#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/judge/evaluation/metrics.h"

namespace nlo::trainer {

/// An experiment whose logs are split for a search, with its data.
struct SearchTask {
  Experiment experiment;  ///< as it stands; with logs: those held out are its validation_files
  RunData data;           ///< data of the experiment
  std::string held_out;   ///< logs that were taken from training to choose by; empty: none
};

/// Makes the task. If the experiment names no validation_files, every fourth of its training logs is held out. Throws
/// codegen::Error if there is only one log, and for rounds of [feedback], which --auto does not search.
SearchTask search_task(Experiment experiment, const std::string& data_directory);

/// Training data of a candidate: the task's own, unless a transient of the candidate's length is cut off.
class CandidateData {
 public:
  CandidateData(const SearchTask& task, const Experiment& candidate);

  const RunData& get() const { return own_ ? *own_ : task_.data; }

 private:
  const SearchTask& task_;
  std::optional<RunData> own_;
};

/// Judges candidates on whole runs from the first sample, as in flight, that neither training nor any test has seen.
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
