// SPDX-License-Identifier: MIT
// Commands that are programs of their own, beside nlo, which users of observers need not build.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace nlo::trainer {

/// Makes `command` of nlo, once it is parsed, replace this process by `program` beside it, with all arguments behind
/// the command. The other program parses them, and prints the help.
/// Throws codegen::Error, with how to build it, where the program cannot be started.
void becomes(CLI::App& command, const std::string& program, int argc, char** argv);

}  // namespace nlo::trainer
