// SPDX-License-Identifier: MIT
#include "trainer/app/jobs/kept_training.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "codegen/model_file/model_file.h"
#include "trainer/base/version.h"
#include "trainer/choose/left_out.h"
#include "trainer/learn/training/checkpoint.h"

namespace nlo::trainer {

std::string kept_folder(const std::string& root, const FinishedRun& inputs) {
  const std::string text = fmt::format("{}\n{}\n{}", kVersion, inputs.experiment, inputs.data);
  return fmt::format("{}/{:016x}", root, fingerprint(text.data(), text.size()));
}

TrainingResult resume_or_begin(const std::string& directory, const JobContext& context, const TrainingWork& work) {
  TrainOptions options;
  options.directory = directory;
  options.stop = context.stop;
  options.progress = [&](const TrainProgress& step) {
    context.progress(static_cast<double>(step.step) / static_cast<double>(step.steps));
  };
  options.resume = !directory.empty() && (has_checkpoint(directory) || folds_have_begun(directory));
  try {
    return work(options);
  } catch (const codegen::InputError&) {
    if (!options.resume) throw;
    options.resume = false;
    return work(options);
  }
}

JobEnd load_or_train(const std::string& directory, const FinishedRun& inputs, const JobContext& context,
                     const TrainingWork& work, codegen::Model& model) {
  const std::string file = directory + "/model.json";
  if (const auto kept = directory.empty() ? std::nullopt : read_finished_run(directory);
      kept && kept->experiment == inputs.experiment && kept->data == inputs.data) {
    model = codegen::read_model(file);
    return JobEnd::kFound;
  }
  TrainingResult result = resume_or_begin(directory, context, work);
  if (result.outcome == TrainOutcome::kInterrupted) return JobEnd::kStopped;
  if (result.outcome == TrainOutcome::kDiverged)
    throw codegen::Error(fmt::format("{}: {}", context.name, result.message));
  model = std::move(result.model);
  if (directory.empty()) return JobEnd::kDone;
  codegen::write_model(model, file);
  write_finished_run(directory, inputs);
  std::error_code ignored;
  std::filesystem::remove(directory + "/checkpoint.bin", ignored);
  return JobEnd::kDone;
}

}  // namespace nlo::trainer
