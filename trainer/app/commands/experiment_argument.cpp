// SPDX-License-Identifier: MIT
#include "trainer/app/commands/experiment_argument.h"

#include <fmt/format.h>

#include <filesystem>

#include "codegen/base/error.h"
#include "trainer/base/nearest_name.h"
#include "trainer/base/printable.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/shipped.h"

namespace nlo::trainer {

namespace {

/// Returns parse(text, name, overrides) of a shipped experiment, or read(path, overrides) of a file.
template <class Read, class Parse>
auto read_argument(const ExperimentArgument& argument, const Read& read, const Parse& parse) {
  std::vector<std::string> overrides = argument.overrides;
  if (argument.seed) overrides.push_back(fmt::format("seed={}", *argument.seed));
  if (argument.threads) overrides.push_back(fmt::format("threads={}", *argument.threads));

  std::error_code ignored;
  if (std::filesystem::exists(argument.experiment, ignored)) return read(argument.experiment, overrides);
  std::vector<std::string> names;
  for (const ShippedExperiment& shipped : shipped_experiments()) {
    if (shipped.name == argument.experiment) return parse(shipped.text, argument.experiment + ".toml", overrides);
    names.emplace_back(shipped.name);
  }
  const std::string nearest = nearest_name(argument.experiment, names);
  throw codegen::Error(fmt::format("{}: no such file, and no experiment of that name; {}", argument.experiment,
                                   nearest.empty() ? fmt::format("there are: {}", fmt::join(names, ", "))
                                                   : fmt::format("did you mean \"{}\"?", nearest)));
}

using Overrides = std::vector<std::string>;

}  // namespace

DraftExperiment read_draft(const ExperimentArgument& argument) {
  return read_argument(
      argument, [](const std::string& path, const Overrides& overrides) { return read_draft(path, overrides); },
      [](std::string_view text, const std::string& name, const Overrides& overrides) {
        return parse_draft(text, name, overrides);
      });
}

Experiment read_experiment(const ExperimentArgument& argument) {
  return read_argument(
      argument, [](const std::string& path, const Overrides& overrides) { return read_experiment(path, overrides); },
      [](std::string_view text, const std::string& name, const Overrides& overrides) {
        return parse_experiment(text, name, overrides);
      });
}

std::string command_words(const ExperimentArgument& argument, const std::string& data) {
  std::string words = shell_word(argument.experiment);
  if (!data.empty()) words += " --data " + shell_word(data);
  for (const std::string& assignment : argument.overrides) words += " --set " + shell_word(assignment);
  if (argument.seed) words += fmt::format(" --seed {}", *argument.seed);
  return words;
}

}  // namespace nlo::trainer
