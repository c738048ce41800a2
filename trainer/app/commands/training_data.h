// SPDX-License-Identifier: MIT
// What an experiment trains on, is chosen by and is judged by.
#pragma once

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
  Dataset training, validation;
  ReportedLogs judged;  ///< of logs; a plant is tested on new trajectories
  LogReport clock;      ///< of logs
  TrainingLogs remembered = {};
  std::vector<std::string> warnings = {};  ///< of simulated runs
};

/// Of an experiment with a [plant].
RunData simulated_data(const Experiment& experiment);

/// Of an experiment with a [log], whose files are below `directory`. Unless `quiet`, what is worth knowing of them goes
/// to stderr. Throws codegen::Error.
RunData logged_data(const Experiment& experiment, const std::string& directory, bool quiet);

/// An experiment that is complete, with its data.
struct PreparedRun {
  Experiment experiment;
  RunData data;
  bool derived = false;  ///< a recipe completed it
};

/// Loads or simulates what a draft trains on and, where it is not complete, derives the rest from that. Unless `quiet`,
/// what was derived goes to stderr. Throws codegen::Error, or RunFailure for a plant that leaves the numbers.
PreparedRun prepare_run(const DraftExperiment& draft, const std::string& directory, bool quiet);

/// Delays of inputs that are to be found, before anything is read by them:
/// from then on the experiment has them as numbers.
void find_delays(Experiment& experiment, const std::string& directory, bool quiet);

}  // namespace nlo::trainer
