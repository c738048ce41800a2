// SPDX-License-Identifier: MIT
#include "trainer/app/commands/run_folder.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "codegen/base/error.h"
#include "codegen/model_file/model_file.h"
#include "trainer/app/commands/command.h"
#include "trainer/choose/left_out.h"
#include "trainer/learn/training/checkpoint.h"

namespace nlo::trainer {
namespace {

std::string model_in(const std::string& folder) {
  return folder + "/model.json";
}

bool has_model(const std::string& folder) {
  std::error_code ignored;
  return std::filesystem::exists(model_in(folder), ignored);
}

/// Returns the name of the experiment whose model is in a file; empty if there is none.
std::string owner_of(const std::string& model) {
  try {
    return codegen::read_model(model).name;
  } catch (const codegen::Error&) {
    return "";
  }
}

void refuse_a_foreign_model(const std::string& folder, const std::string& experiment_name) {
  if (!has_model(folder)) return;
  const std::string model = model_in(folder), owner = owner_of(model);
  if (owner.empty())
    throw codegen::Error(fmt::format(
        "{}: is not a model of nlo; choose another directory with -o DIR, or replace it with --force", model));
  if (owner != experiment_name)
    throw codegen::Error(
        fmt::format("{}: holds the model of another experiment, {}; choose another directory with "
                    "-o DIR, or replace it with --force",
                    model, owner));
}

}  // namespace

RunFolder::RunFolder(const std::string& path, const Experiment& experiment, bool force)
    : path_(path), last_round_(experiment.feedback ? experiment.feedback->rounds : 0), taken_(path) {
  if (!force) refuse_a_foreign_model(path_, experiment.name);
}

bool RunFolder::holds(const FinishedRun& run) const {
  const auto found = read_finished_run(path_);
  if (!found || found->experiment != run.experiment || found->data != run.data) return false;
  if (!found->failure.empty()) throw RunFailure(fmt::format("{}: {}", path_, found->failure));
  return true;
}

bool RunFolder::can_resume() const {
  if (has_begun(0) || has_begun(last_round_)) return true;
  if (has_model(path_))
    throw codegen::Error(fmt::format(
        "{}/checkpoint.bin: there is no such file, so the training cannot be resumed; start without --resume", path_));
  return false;
}

std::string RunFolder::of_round(int round) const {
  return round == last_round_ ? path_ : fmt::format("{}/round_{}", path_, round);
}

bool RunFolder::has_begun(int round) const {
  return has_checkpoint(of_round(round)) || folds_have_begun(of_round(round));
}

void RunFolder::forget_rounds() const {
  std::error_code ignored;
  for (int round = 0; last_round_ > 0 && round <= last_round_; ++round)
    std::filesystem::remove(of_round(round) + "/checkpoint.bin", ignored);
}

}  // namespace nlo::trainer
