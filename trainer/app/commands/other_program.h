// SPDX-License-Identifier: MIT
// Commands that are separate programs in the folder of nlo. Users of observers need not build them.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace nlo::trainer {

/// Makes `command` of nlo replace this process by `program` in the same folder, with all arguments after the command.
/// The other program parses them and prints the help. Throws codegen::Error, with the build command, if the program
/// cannot be started.
void becomes(CLI::App& command, const std::string& program, int argc, char** argv);

}  // namespace nlo::trainer
