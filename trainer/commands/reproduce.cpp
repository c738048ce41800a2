// SPDX-License-Identifier: MIT
// nlo reproduce: becomes the program nlo-reproduce, so that nobody builds the paper who wants an observer.
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <memory>
#include <system_error>
#include <vector>

#include "trainer/commands/command.h"
#include "trainer/commands/reproduce_options.h"

namespace nlo::trainer {
namespace {

/// Replaces this program by the one beside it, with all arguments but the first and that at `command`. Throws
/// codegen::Error where it cannot be started.
[[noreturn]] void become_reproduce(std::vector<char*> arguments, std::size_t command) {
  std::string program = std::filesystem::read_symlink("/proc/self/exe").replace_filename("nlo-reproduce").string();
  arguments.front() = program.data();
  arguments.erase(arguments.begin() + static_cast<std::ptrdiff_t>(command));
  arguments.push_back(nullptr);
  ::execv(program.c_str(), arguments.data());
  throw codegen::Error(
      fmt::format("{}: {}; nlo reproduce is a program of its own: build it with `cmake --build build/release --target "
                  "nlo-reproduce`, or install the package nlo, which has it beside nlo",
                  program, std::generic_category().message(errno)));
}

}  // namespace

void add_reproduce(CLI::App& app, int argc, char** argv) {
  CLI::App* command = app.add_subcommand("reproduce", kReproduceDescription);
  auto arguments = std::make_shared<ReproduceArguments>();  // for the help: the other program parses
  add_reproduce_options(*command, *arguments,
                        "Runs the program nlo-reproduce, which lies beside nlo: `cmake --build build/release --target "
                        "nlo-reproduce` builds it.\n");
  command->preparse_callback([arguments, all = std::vector<char*>(argv, argv + argc)](std::size_t behind_command) {
    become_reproduce(all, all.size() - 1 - behind_command);
  });
}

}  // namespace nlo::trainer
