// SPDX-License-Identifier: MIT
// The data of nlo train --auto for the training and the choice of its candidates.
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
  Experiment experiment;  ///< the given experiment; with logs: those held out are its validation_files
  RunData data;           ///< data of the experiment
  std::string held_out;   ///< logs that were held out of training for the choice; empty: none
};

/// Makes the task. If the experiment names no validation_files, every fourth of its training logs is held out. Throws
/// codegen::Error if there is only one log, and for rounds of [feedback], which --auto does not search.
SearchTask search_task(Experiment experiment, const std::string& data_directory);

/// Training data of a candidate: those of the task, unless a transient of the candidate's length is cut off.
class CandidateData {
 public:
  CandidateData(const SearchTask& task, const Experiment& candidate);

  const RunData& get() const { return own_ ? *own_ : task_.data; }

 private:
  const SearchTask& task_;
  std::optional<RunData> own_;
};

/// Evaluates candidates on whole runs from the first sample, as in flight. Neither training nor any test uses these
/// runs.
class SearchJudge {
 public:
  /// `validation`: validation runs of an experiment with logs. For a plant new runs are simulated.
  SearchJudge(const Experiment& experiment, const Dataset& validation);

  /// Returns the norm under the noise of the training (for a mixture the mean over its parts). If the units of states
  /// differ or the loss is normalised, states are divided by their deviation. Throws codegen::Error if an estimate is
  /// NaN.
  double error(const codegen::Model& model) const;

 private:
  const Experiment& experiment_;
  Dataset runs_;
  MetricsConfig config_;
};

}  // namespace nlo::trainer
