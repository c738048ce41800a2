// SPDX-License-Identifier: MIT
// The data of a run: for training, for the choice of the model and for the final test.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trainer/app/commands/run_report.h"
#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/data/log_dataset.h"
#include "trainer/data/training_logs.h"
#include "trainer/experiments/load_experiment.h"

namespace nlo::trainer {

struct RunData {
  Dataset training;
  Dataset validation;      ///< empty: the training logs also choose the model
  Dataset judged = {};     ///< logs that test the model, if no other set contains them whole
  std::string split = {};  ///< their split, as in ReportedLogs; a plant is tested on new trajectories
  LogReport clock = {};    ///< report of the logs' clock
  TrainingLogs remembered = {};
  std::vector<std::string> warnings = {};  ///< warnings about simulated runs

  /// Returns the set that chooses the model.
  const Dataset& choosing() const { return validation.trajectories.empty() ? training : validation; }
  /// Returns the logs that test the model.
  ReportedLogs reported() const {
    if (!judged.trajectories.empty()) return {judged, split};
    return {split == "training" ? training : validation, split};
  }
};

/// Simulates the data of an experiment with a [plant].
RunData simulated_data(const Experiment& experiment);

/// Loads the data of an experiment with a [log] from files below `directory`. Unless `quiet`, prints notes to stderr.
/// Throws codegen::Error.
RunData logged_data(const Experiment& experiment, const std::string& directory, bool quiet);

/// An experiment that is prepared for its training, with its data.
struct PreparedRun {
  Experiment experiment;
  RunData data;          ///< empty until its logs are read or its plant is simulated
  bool derived = false;  ///< true if a recipe completes it
};

/// Loads the logs of a draft. A plant is not simulated yet, because this takes longer. Unless `quiet`, prints notes to
/// stderr. Throws codegen::Error.
PreparedRun read_logs(const DraftExperiment& draft, const std::string& directory, bool quiet);

/// Returns a hash of the logs of read_logs(); 0 for a plant, whose runs follow from the experiment.
std::uint64_t logs_fingerprint(const PreparedRun& run);

/// Simulates the plant, and derives the missing keys from the data if the draft is not complete. The arguments are
/// those of read_logs(), which made `run`. Unless `quiet`, the derived keys are printed on stderr. Throws
/// codegen::Error, or RunFailure for a plant whose states do not stay finite.
void simulate_and_derive(const DraftExperiment& draft, const std::string& directory, bool quiet, PreparedRun& run);

/// Prints the warnings about simulated runs to stderr. `nlo train` prints them even if quiet.
void print_warnings(const std::vector<std::string>& warnings);

/// Finds delays of inputs before they are used. From then on the experiment has them as numbers.
void find_delays(Experiment& experiment, const std::string& directory, bool quiet);

}  // namespace nlo::trainer
