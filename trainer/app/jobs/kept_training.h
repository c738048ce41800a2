// SPDX-License-Identifier: MIT
// A training whose folder says how far it is, so that it may be killed at any moment: checkpoint.bin while it lasts,
// then model.json and finished.json (finished_run.h), which identifies the model's inputs.
#pragma once

#include <functional>
#include <string>

#include "codegen/model/model.h"
#include "trainer/app/jobs/finished_run.h"
#include "trainer/app/jobs/run_jobs.h"
#include "trainer/learn/training/train.h"

namespace nlo::trainer {

/// ROOT/<16 hex digits> of the inputs and of the program's version.
std::string kept_folder(const std::string& root, const FinishedRun& inputs);

/// Trains with these options: where to keep checkpoints and whether to go on from one, how to stop, whom to tell.
using TrainingWork = std::function<TrainingResult(const TrainOptions& options)>;

/// Runs `work` in `directory`, from its checkpoint there if it was stopped or killed. A damaged checkpoint costs its
/// steps, not the run. With an empty directory nothing is kept.
TrainingResult resume_or_begin(const std::string& directory, const JobContext& context, const TrainingWork& work);

/// Sets `model` to the one in `directory`, if it is complete and made from these inputs; else to the result of `work`,
/// which is kept there. Throws codegen::Error when the training diverges or a file cannot be written.
JobEnd load_or_train(const std::string& directory, const FinishedRun& inputs, const JobContext& context,
                     const TrainingWork& work, codegen::Model& model);

}  // namespace nlo::trainer
