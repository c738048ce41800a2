// SPDX-License-Identifier: MIT
#include "trainer/app/commands/other_program.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>
#include <vector>

#include "codegen/base/error.h"
#include "trainer/app/commands/command.h"

namespace nlo::trainer {
namespace {

/// Replaces this program by another one in the same folder, with all arguments except the first and the one at
/// `command`.
[[noreturn]] void become(const std::string& name, const std::string& command_name, std::vector<char*> arguments,
                         std::size_t command) {
  std::string program = std::filesystem::read_symlink("/proc/self/exe").replace_filename(name).string();
  arguments.front() = program.data();
  arguments.erase(arguments.begin() + static_cast<std::ptrdiff_t>(command));
  arguments.push_back(nullptr);
  ::execv(program.c_str(), arguments.data());
  throw codegen::Error(
      fmt::format("{}: {}; nlo {} is a separate program: build it with `cmake --build build/release --target {}`, or "
                  "install the package nlo, which contains it",
                  program, std::generic_category().message(errno), command_name, name));
}

}  // namespace

void becomes(CLI::App& command, const std::string& program, int argc, char** argv) {
  command.preparse_callback(
      [program, name = command.get_name(), all = std::vector<char*>(argv, argv + argc)](std::size_t behind_command) {
        become(program, name, all, all.size() - 1 - behind_command);
      });
}

void add_certify(CLI::App& app, int argc, char** argv) {
  becomes(*app.add_subcommand("certify", kCertifyDescription), "nlo-prove", argc, argv);
}

void add_reproduce(CLI::App& app, int argc, char** argv) {
  becomes(*app.add_subcommand("reproduce", kReproduceDescription), "nlo-reproduce", argc, argv);
}

}  // namespace nlo::trainer
