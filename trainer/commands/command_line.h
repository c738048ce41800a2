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
  std::vector<std::string> names;          ///< "-o", "--output"; empty for a positional argument
  std::string positional;                  ///< "MODEL"; empty for an option
  std::string value;                       ///< what stands for its value in --help: "TEXT", "DIR"; empty for a flag
  std::vector<std::string> members;        ///< the only values that it takes; empty: not listed
  std::string range;                       ///< "1 to 100" of a number; empty: none
  std::string fallback;                    ///< its default value; empty: none to show
  bool required = false, repeats = false;  ///< repeats: takes several values
  std::string description;
};

struct CommandFacts {
  std::string name, description, footer;
  std::vector<OptionFacts> options;
};

OptionFacts facts_of(const CLI::Option& option);
CommandFacts facts_of(const CLI::App& app);

/// The values that an option or argument takes, where tables list them: its members, or names of shipped experiments,
/// identifications, targets and examples of the paper.
std::vector<std::string> values_of(const OptionFacts& option);

/// The subcommands in the order of --help.
std::vector<CommandFacts> commands_of(const CLI::App& app);

/// The manual page of a program as roff with man macros. No date: the same program gives the same bytes.
std::string man_page(const CLI::App& app);

/// A script that bash sources: completes commands, options, their values, names of shipped experiments and files.
std::string bash_completion(const CLI::App& app);

/// The same for zsh, with what each option means: sourced, or as _nlo in a folder of fpath.
std::string zsh_completion(const CLI::App& app);

}  // namespace nlo::trainer
