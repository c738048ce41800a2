// SPDX-License-Identifier: MIT
// Adds a command to the program `nlo`, and defines the exit codes of its errors.
//   0  done
//   1  RunFailure: the run itself failed (diverged, interrupted, disk full)
//   2  any other codegen::Error, before anything was written: wrong usage, config or input; codegen::InputError always
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <utility>

#include "codegen/base/error.h"

namespace nlo::trainer {

struct RunFailure : codegen::Error {
  using Error::Error;
};

/// Runs `work`. An error in it is a failure of the run (RunFailure) and not of the input, except InputError.
template <class Work>
auto run_phase(Work&& work) {
  try {
    return std::forward<Work>(work)();
  } catch (const codegen::InputError&) {
    throw;
  } catch (const codegen::Error& error) {
    throw RunFailure(error.what());
  }
}

/// Each function adds a subcommand. If the user chooses the subcommand, parsing sets `action` to its work.
using Action = std::function<void()>;
void add_train(CLI::App& app, Action& action);
void add_compare(CLI::App& app, Action& action);
void add_crossvalidate(CLI::App& app, Action& action);
void add_identify(CLI::App& app, Action& action);
void add_evaluate(CLI::App& app, Action& action);
void add_export(CLI::App& app, Action& action);
void add_replay(CLI::App& app, Action& action);
void add_report(CLI::App& app, Action& action);
void add_monitor(CLI::App& app, Action& action);
void add_new(CLI::App& app, Action& action);
void add_simulate(CLI::App& app, Action& action);
void add_sweep(CLI::App& app, Action& action);

/// Adds the subcommands that start another program, with the arguments of main (other_program.h).
void add_certify(CLI::App& app, int argc, char** argv);
void add_reproduce(CLI::App& app, int argc, char** argv);

inline constexpr const char* kCertifyDescription =
    "Prove bounds of a model, rounding included, and search for counterexamples";
inline constexpr const char* kReproduceDescription =
    "Make the paper's tables and figures beside the paper's numbers, and run published benchmarks";

}  // namespace nlo::trainer
