// SPDX-License-Identifier: MIT
// The command line of `nlo reproduce`: that of the program nlo-reproduce, and in the help of `nlo`.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace nlo::trainer {

struct ReproduceArguments {
  std::string what, directory = "reproduction", data;
  bool quick = false;
  int seeds = 0;    ///< 0: 3, or 1 when quick
  int threads = 0;  ///< 0: all cores; does not change a result
};

inline constexpr const char* kReproduceDescription =
    "Make the paper's tables and figures, beside the paper's numbers, and tasks that others set";

/// Parsing fills `arguments`. The footer of the help begins with `about_what`.
void add_reproduce_options(CLI::App& app, ReproduceArguments& arguments, const std::string& about_what);

}  // namespace nlo::trainer
