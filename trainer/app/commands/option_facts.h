// SPDX-License-Identifier: MIT
// Facts about an option of the command line for --help, read from CLI11's tables.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace nlo::trainer {

/// One option, flag or positional argument.
struct OptionFacts {
  std::string value;                       ///< word for the value in --help: "TEXT", "DIR"; empty for a flag
  std::vector<std::string> members;        ///< the allowed values; empty: not listed
  std::string range;                       ///< "1 to 100" for a number; empty: no range
  std::string fallback;                    ///< default value; empty: not shown
  bool required = false, repeats = false;  ///< repeats: takes several values
  std::string description;
};

OptionFacts facts_of(const CLI::Option& option);

}  // namespace nlo::trainer
