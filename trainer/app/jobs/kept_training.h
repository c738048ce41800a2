// SPDX-License-Identifier: MIT
// A training that may be killed at any moment, because its folder contains its state: checkpoint.bin during the
// training, later model.json and finished.json (finished_run.h). The latter identifies the inputs of the model.
#pragma once

#include <functional>
#include <string>

#include "codegen/model/model.h"
#include "trainer/app/jobs/finished_run.h"
#include "trainer/app/jobs/run_jobs.h"
#include "trainer/learn/training/train.h"

namespace nlo::trainer {

/// Returns ROOT/<16 hex digits>, a hash of the inputs and the program's version.
std::string kept_folder(const std::string& root, const FinishedRun& inputs);

/// Trains with these options: folder of checkpoints, whether to resume, the stop flag, and progress.
using TrainingWork = std::function<TrainingResult(const TrainOptions& options)>;

/// Runs `work` in `directory`, from its checkpoint if it was interrupted or killed. If the checkpoint is damaged,
/// the training begins again. If the name `directory` is empty, no file is stored.
TrainingResult resume_or_begin(const std::string& directory, const JobContext& context, const TrainingWork& work);

/// Sets `model` to the one in `directory`, if it is complete and made from these inputs; otherwise to the result of
/// `work`, which is stored there. Throws codegen::Error if the training diverges or a file cannot be written.
JobEnd load_or_train(const std::string& directory, const FinishedRun& inputs, const JobContext& context,
                     const TrainingWork& work, codegen::Model& model);

}  // namespace nlo::trainer
