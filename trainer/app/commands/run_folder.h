// SPDX-License-Identifier: MIT
// The folder of a training. A command locks it once, before it computes anything, and keeps it until its end.
#pragma once

#include <string>

#include "trainer/app/commands/output_directory.h"
#include "trainer/app/jobs/finished_run.h"
#include "trainer/config/experiment.h"

namespace nlo::trainer {

class RunFolder {
 public:
  /// Locks the folder. Throws like OutputDirectory, and codegen::Error if it holds the model of another experiment
  /// (unless `force`).
  RunFolder(const std::string& path, const Experiment& experiment, bool force);

  const std::string& path() const { return path_; }

  /// Returns true if this run has already finished here, so that nothing is to be done. Throws RunFailure if it failed.
  bool holds(const FinishedRun& run) const;

  /// Returns true if there is a checkpoint to continue from, false if there is neither a checkpoint nor a model. Throws
  /// codegen::Error for a model without a checkpoint.
  bool can_resume() const;

  /// Returns the number of the last round of [feedback]; 0 without one.
  int last_round() const { return last_round_; }

  /// Returns the folder of a round's checkpoint; the last round uses the folder of the run.
  std::string of_round(int round) const;

  /// Returns true if the round can be resumed.
  bool has_begun(int round) const;

  /// Removes the checkpoints of all rounds, which a resumed run would otherwise use.
  void forget_rounds() const;

 private:
  std::string path_;
  int last_round_;
  OutputDirectory taken_;
};

}  // namespace nlo::trainer
