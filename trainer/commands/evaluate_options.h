// SPDX-License-Identifier: MIT
// The command line of `nlo evaluate`.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "trainer/commands/run_files.h"
#include "trainer/compare/runs_under.h"
#include "trainer/compare/strict_study.h"

namespace nlo::trainer {

struct EvaluateArguments {
  std::vector<std::string> models, noise_words, data, missing;
  std::vector<double> from_s;
  std::string columns, input_noise = "none";
  RunFiles files;
  StrictTest test;
  Condition common;  ///< what all noises are tested under
  std::vector<NoiseConfig> noises;
  bool json = false;
  std::string plant_option;  ///< the first that was given of those that are for plants
};

/// Parsing fills `arguments`. Returns the options that are for plants.
std::vector<CLI::Option*> add_evaluate_options(CLI::App* command, EvaluateArguments& arguments);

}  // namespace nlo::trainer
