// SPDX-License-Identifier: MIT
// The options of a command, one statement each: name, variable, meaning. Options of several commands are defined here
// once.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "trainer/app/commands/experiment_argument.h"

namespace nlo::trainer {

/// Checks of options for CLI11. They return an empty text for a valid value, otherwise the expected form. They are
/// needed because CLI11's own checks convert -1 to a large unsigned number and accept NaN in every range.
std::string check_seed(const std::string& text);
std::string check_scale(const std::string& text);
std::string check_minutes(const std::string& text);

class Options {
 public:
  explicit Options(CLI::App& command) : command_(command) {}

  CLI::Option* flag(const std::string& name, bool& to, const std::string& meaning) {
    return command_.add_flag(name, to, meaning);
  }

  /// `type`: name of the value in the help, if the C++ type does not show it.
  template <class T>
  CLI::Option* value(const std::string& name, T& to, const std::string& meaning, const std::string& type = "") {
    CLI::Option* option = command_.add_option(name, to, meaning);
    return type.empty() ? option : option->type_name(type);
  }

  /// Adds an option whose help shows its default.
  template <class T>
  CLI::Option* shown(const std::string& name, T& to, const std::string& meaning, const std::string& type = "") {
    return value(name, to, meaning, type)->capture_default_str();
  }

  /// Adds a number from `low` to `high`, with its default.
  template <class T>
  CLI::Option* number(const std::string& name, T& to, T low, T high, const std::string& meaning) {
    return shown(name, to, meaning)->check(CLI::Range(low, high));
  }

  /// Adds an option that may be given several times, with one value each.
  template <class T>
  CLI::Option* repeated(const std::string& name, std::vector<T>& to, const std::string& meaning,
                        const std::string& type = "") {
    return value(name, to, meaning, type)->allow_extra_args(false);
  }

  /// Adds an option with values separated by commas.
  template <class T>
  CLI::Option* list(const std::string& name, std::vector<T>& to, const std::string& meaning,
                    const std::string& type = "") {
    return repeated(name, to, meaning, type)->delimiter(',');
  }

  template <class Seed>
  CLI::Option* seed(Seed& to, const std::string& meaning) {
    return shown("--seed", to, meaning)->check(check_seed);
  }
  CLI::Option* threads(int& to, const std::string& meaning = kThreads) {
    return number("--threads", to, 0, 1024, meaning);
  }
  CLI::Option* changes(std::vector<std::string>& to, const std::string& meaning = kSet) {
    return repeated("--set", to, meaning, "KEY=VALUE");
  }
  CLI::Option* directory(const std::string& name, std::string& to, const std::string& meaning) {
    return value(name, to, meaning, "DIR");
  }

  /// Adds --set, --seed and --threads, which override an experiment.
  void experiment(ExperimentArgument& to);

 private:
  static constexpr const char* kThreads = "number of threads; 0: all cores; does not affect the result";
  static constexpr const char* kSet = "SECTION.KEY=VALUE: value that replaces the value in the file; may be repeated";

  CLI::App& command_;
};

}  // namespace nlo::trainer
