// SPDX-License-Identifier: MIT
// A training whose folder says how far it is, so that it may be killed at any moment: checkpoint.bin while it lasts,
// then model.json and finished.json, which tells what that model was made from.
// finished.json, the last file that nlo train writes: the run of this experiment, on this data, came to its end and to
// this model. A run that is killed before leaves none, or that of another model.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "codegen/model/model.h"
#include "trainer/app/jobs/run_jobs.h"
#include "trainer/config/experiment.h"
#include "trainer/learn/training/train.h"

namespace nlo::trainer {

struct FinishedRun {
  std::uint64_t experiment = 0;  ///< run_identity()
  std::uint64_t data = 0;        ///< hash of the logs; 0 of a plant, whose runs follow from the experiment
  std::string failure = {};      ///< why the model is not to be trusted: diverged, or got nowhere; else empty
};

/// Hash of all that an experiment says, steps and seed included, before anything is found out from data.
std::uint64_t run_identity(const Experiment& experiment);

/// Writes DIR/finished.json beside the model.json that it is about. Throws codegen::Error.
void write_finished_run(const std::string& directory, const FinishedRun& run);

/// Empty where no run has finished, or where model.json is no longer that of the run.
std::optional<FinishedRun> read_finished_run(const std::string& directory);

/// ROOT/<16 hex digits> of the inputs and of the program's version.
std::string kept_folder(const std::string& root, const FinishedRun& inputs);

/// Trains with these options: where to keep checkpoints and whether to go on from one, how to stop, whom to tell.
using Train = std::function<TrainingResult(const TrainOptions& options)>;

/// Runs `train` in `directory`, from what it left there when it was stopped or killed. A damaged checkpoint costs its
/// steps, not the run. With an empty directory nothing is kept.
TrainingResult train_in(const std::string& directory, const JobContext& context, const Train& train);

/// `model` becomes the one that is kept in `directory`, if it is whole and made from these inputs; else what `train`
/// gives there, which is kept. Throws codegen::Error when the training diverges or a file cannot be written.
JobEnd train_kept(const std::string& directory, const FinishedRun& inputs, const JobContext& context,
                  const Train& train, codegen::Model& model);

}  // namespace nlo::trainer
