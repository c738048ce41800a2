// SPDX-License-Identifier: MIT
// The command line as data, read from CLI11's own tables: what the man page and the completion are made of, so that
// neither can say anything else than --help.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace nlo::trainer {

/// One option, flag or positional argument.
struct OptionFacts {
  std::vector<std::string> names;    ///< "-o", "--output"; empty for a positional argument
  std::string positional;            ///< "MODEL"; empty for an option
  std::string value;                 ///< what stands for its value in --help: "TEXT", "DIR"; empty for a flag
  std::vector<std::string> members;  ///< the only values that it takes; empty: not listed
  std::string fallback;              ///< its default value; empty: none to show
  bool required = false;
  std::string description;
};

struct CommandFacts {
  std::string name, description, footer;
  std::vector<OptionFacts> options;
};

CommandFacts facts_of(const CLI::App& app);

/// The subcommands in the order of --help.
std::vector<CommandFacts> commands_of(const CLI::App& app);

/// The manual page nlo(1) as roff with man macros. No date: the same program gives the same bytes.
std::string man_page(const CLI::App& app, const std::string& version);

/// A script that bash sources: completes commands, options, their values, names of shipped experiments and files.
std::string bash_completion(const CLI::App& app);

}  // namespace nlo::trainer
