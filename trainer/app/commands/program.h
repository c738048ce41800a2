// SPDX-License-Identifier: MIT
// Help, errors and exit codes (command.h) of `nlo`, `nlo-prove` and `nlo-reproduce`.
#pragma once

#include <functional>

#include "trainer/app/commands/command.h"

namespace nlo::trainer {

/// Reads the command line of the program `name` and executes it. `add` adds options and commands, and sets the action,
/// at once or when a command is parsed. Returns the exit code. Results go to stdout, an error is one line on stderr.
/// The arguments are not strings, because a failed allocation before the call would not be reported.
int run_program(int argc, char** argv, const char* name, const char* description,
                const std::function<void(CLI::App& app, Action& action)>& add);

}  // namespace nlo::trainer
