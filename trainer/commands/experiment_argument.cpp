// SPDX-License-Identifier: MIT
#include "trainer/commands/experiment_argument.h"

#include <fmt/format.h>

#include <filesystem>

#include "codegen/base/error.h"
#include "trainer/base/nearest_name.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/shipped.h"

namespace nlo::trainer {

Experiment read_experiment(const ExperimentArgument& argument) {
  std::vector<std::string> overrides = argument.overrides;
  if (argument.seed) overrides.push_back(fmt::format("seed={}", *argument.seed));
  if (argument.threads) overrides.push_back(fmt::format("threads={}", *argument.threads));

  std::error_code ignored;
  if (std::filesystem::exists(argument.experiment, ignored)) return read_experiment(argument.experiment, overrides);
  std::vector<std::string> names;
  for (const ShippedExperiment& shipped : shipped_experiments()) {
    if (shipped.name == argument.experiment)
      return parse_experiment(shipped.text, argument.experiment + ".toml", overrides);
    names.emplace_back(shipped.name);
  }
  const std::string nearest = nearest_name(argument.experiment, names);
  throw codegen::Error(fmt::format("{}: no such file, and no experiment of that name; {}", argument.experiment,
                                   nearest.empty() ? fmt::format("there are: {}", fmt::join(names, ", "))
                                                   : fmt::format("did you mean \"{}\"?", nearest)));
}

}  // namespace nlo::trainer
