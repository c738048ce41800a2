// SPDX-License-Identifier: MIT
// The data of nlo train --auto: what its candidates train on and are chosen by.
#pragma once

#include <optional>
#include <string>

#include "codegen/model/model.h"
#include "trainer/app/commands/run_data.h"
#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/judge/evaluation/metrics.h"

namespace nlo::trainer {

/// An experiment whose logs are split for a search, and what comes of them.
struct SearchTask {
  Experiment experiment;  ///< as it stands; with logs: those held out are its validation_files
  RunData data;           ///< of it
  std::string held_out;   ///< logs that were taken from training to choose by; empty: none
};

/// Where the experiment names no validation_files, every fourth of its training logs is held out. Throws codegen::Error
/// where there is but one, and for what --auto does not search: rounds of [feedback].
SearchTask search_task(Experiment experiment, const std::string& data_directory);

/// What a candidate trains on, which is the task's own unless a transient of its own length is cut off.
class CandidateData {
 public:
  CandidateData(const SearchTask& task, const Experiment& candidate);

  const RunData& get() const { return own_ ? *own_ : task_.data; }

 private:
  const SearchTask& task_;
  std::optional<RunData> own_;
};

/// What candidates are judged by: whole runs from the first sample, as they fly, that neither training nor any test has
/// seen.
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
