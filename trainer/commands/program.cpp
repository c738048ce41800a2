// SPDX-License-Identifier: MIT
#include "trainer/commands/program.h"

#include <fmt/core.h>
#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "trainer/base/nearest_name.h"
#include "trainer/base/printable.h"
#include "trainer/commands/help_formatter.h"
#include "trainer/commands/out_of_memory.h"

namespace nlo::trainer {
namespace {

constexpr int kRunFailed = 1, kWrongUsage = 2;

int complain(const char* what, int code) {
  fmt::print(stderr, "nlo: error: {}\n", printable(what));
  return code;
}

/// The chosen subcommand, or the program.
CLI::App& chosen(CLI::App& app) {
  const auto commands = app.get_subcommands();
  return commands.empty() ? app : *commands.front();
}

/// CLI11's message, and what was meant by an unknown command or option.
std::string usage_message(CLI::App& app, const CLI::ParseError& error) {
  CLI::App& command = chosen(app);
  std::vector<std::string> known;
  if (&command == &app)
    for (const CLI::App* each : app.get_subcommands(nullptr)) known.push_back(each->get_name());
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  const auto extras = app.remaining(true);
  std::string message = error.what();
  if (&command == &app && app.get_require_subcommand_min() > 0 && !extras.empty())
    message = fmt::format("unknown command \"{}\"", extras.front());
  for (char& c : message)
    if (c == '\n') c = ' ';
  for (const std::string& extra : extras) {
    const std::string nearest = nearest_name(extra.substr(0, extra.find('=')), known);
    if (!nearest.empty()) message += fmt::format("; did you mean \"{}\"?", nearest);
  }
  const std::string name = &command == &app ? "" : " " + command.get_name();
  return fmt::format("{}; see {}{} --help", message, app.get_name(), name);
}

int parse_and_act(CLI::App& app, const Action& action, int argc, char** argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {  // --help, --version
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    return complain(usage_message(app, error).c_str(), kWrongUsage);
  }
  action();
  return 0;
}

}  // namespace

int run_program(int argc, char** argv, const char* name, const char* description,
                const std::function<void(CLI::App& app, Action& action)>& add) {
  end_where_memory_ends();
  try {
    CLI::App app(description, name);
    app.formatter(std::make_shared<HelpFormatter>(help_width()));  // of its commands too
    Action action;
    add(app, action);
    const int code = parse_and_act(app, action, argc, argv);
    if (std::fflush(stdout) != 0) return complain("writing to stdout failed", kRunFailed);
    return code;
  } catch (const RunFailure& error) {
    return complain(error.what(), kRunFailed);
  } catch (const codegen::Error& error) {
    return complain(error.what(), kWrongUsage);
  } catch (const std::exception& error) {
    return complain(error.what(), kRunFailed);
  }
}

}  // namespace nlo::trainer
