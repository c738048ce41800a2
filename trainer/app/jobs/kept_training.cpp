// SPDX-License-Identifier: MIT
#include "trainer/app/jobs/kept_training.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
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

TrainingResult train_in(const std::string& directory, const JobContext& context, const Train& train) {
  TrainOptions options;
  options.directory = directory;
  options.stop = context.stop;
  options.progress = [&](const TrainProgress& step) {
    context.progress(static_cast<double>(step.step) / static_cast<double>(step.steps));
  };
  options.resume = !directory.empty() && (has_checkpoint(directory) || begun_by_groups(directory));
  try {
    return train(options);
  } catch (const codegen::InputError&) {
    if (!options.resume) throw;
    options.resume = false;
    return train(options);
  }
}

JobEnd train_kept(const std::string& directory, const FinishedRun& inputs, const JobContext& context,
                  const Train& train, codegen::Model& model) {
  const std::string file = directory + "/model.json";
  if (const auto kept = directory.empty() ? std::nullopt : read_finished_run(directory);
      kept && kept->experiment == inputs.experiment && kept->data == inputs.data) {
    model = codegen::read_model(file);
    return JobEnd::kFound;
  }
  TrainingResult result = train_in(directory, context, train);
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

namespace {

std::string file_in(const std::string& directory) {
  return directory + "/finished.json";
}

std::uint64_t hash_of(const std::string& text) {
  return fingerprint(text.data(), text.size());
}

std::uint64_t hash_of_model(const std::string& directory) {
  return hash_of(codegen::read_file(directory + "/model.json"));
}

}  // namespace

std::uint64_t run_identity(const Experiment& experiment) {
  return hash_of(experiment.source_text + "\n" + std::to_string(experiment.seed));
}

void write_finished_run(const std::string& directory, const FinishedRun& run) {
  const nlohmann::ordered_json json = {{"experiment", run.experiment},
                                       {"data", run.data},
                                       {"model", hash_of_model(directory)},
                                       {"failure", run.failure}};
  codegen::write_file_atomically(file_in(directory),
                                 json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

std::optional<FinishedRun> read_finished_run(const std::string& directory) {
  constexpr std::size_t kMostBytes = std::size_t{1} << 20;
  try {
    const auto json = nlohmann::json::parse(codegen::read_file(file_in(directory), kMostBytes));
    if (json.at("model").get<std::uint64_t>() != hash_of_model(directory)) return std::nullopt;
    return FinishedRun{json.at("experiment").get<std::uint64_t>(), json.at("data").get<std::uint64_t>(),
                       json.at("failure").get<std::string>()};
  } catch (const codegen::Error&) {  // no such file
    return std::nullopt;
  } catch (const nlohmann::json::exception&) {  // not by this program
    return std::nullopt;
  }
}

}  // namespace nlo::trainer
