// SPDX-License-Identifier: MIT
// The program `nlo`: results on stdout, progress and errors on stderr. Exit codes: see commands/command.h.
#include <fmt/core.h>
#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <memory>

#include "trainer/base/nearest_name.h"
#include "trainer/base/printable.h"
#include "trainer/base/version.h"
#include "trainer/commands/command.h"
#include "trainer/commands/help_formatter.h"
#include "trainer/commands/out_of_memory.h"

namespace {

using nlo::trainer::nearest_name;

constexpr int kRunFailed = 1, kWrongUsage = 2;

int complain(const char* what, int code) {
  fmt::print(stderr, "nlo: error: {}\n", nlo::trainer::printable(what));
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
  if (&command == &app && !extras.empty()) message = fmt::format("unknown command \"{}\"", extras.front());
  for (char& c : message)
    if (c == '\n') c = ' ';
  for (const std::string& extra : extras) {
    const std::string nearest = nearest_name(extra.substr(0, extra.find('=')), known);
    if (!nearest.empty()) message += fmt::format("; did you mean \"{}\"?", nearest);
  }
  const std::string name = &command == &app ? "nlo" : "nlo " + command.get_name();
  return fmt::format("{}; see {} --help", message, name);
}

int run(int argc, char** argv) {
  CLI::App app("Neural Luenberger observers: train one from a plant or from logs, evaluate it, export it for firmware.",
               "nlo");
  app.set_version_flag("-V,--version", std::string("nlo ") + nlo::trainer::kVersion);
  app.formatter(
      std::make_shared<nlo::trainer::HelpFormatter>(nlo::trainer::help_width()));  // of the commands below too
  app.require_subcommand(1);
  app.footer(
      "Start with:\n"
      "  nlo train van_der_pol && nlo evaluate runs/van_der_pol/model.json --noise gaussian:0.5\n"
      "  nlo export runs/van_der_pol/model.json -o van_der_pol.h\n"
      "Exit codes: 0 done, 1 the run failed, 2 wrong usage, config or input.");
  nlo::trainer::Action action;
  nlo::trainer::add_new(app, action);
  nlo::trainer::add_train(app, action);
  nlo::trainer::add_evaluate(app, action);
  nlo::trainer::add_compare(app, action);
  nlo::trainer::add_crossvalidate(app, action);
  nlo::trainer::add_identify(app, action);
  nlo::trainer::add_bound(app, action);
  nlo::trainer::add_monitor(app, action);
  nlo::trainer::add_export(app, action);
  nlo::trainer::add_report(app, action);
  nlo::trainer::add_reproduce(app, action);
  nlo::trainer::add_simulate(app, action);
  nlo::trainer::add_sweep(app, action);
  nlo::trainer::add_completion(app, action);
  nlo::trainer::add_man(app, action);
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

int main(int argc, char** argv) {
  nlo::trainer::end_where_memory_ends();
  try {
    const int code = run(argc, argv);
    if (std::fflush(stdout) != 0) return complain("writing to stdout failed", kRunFailed);
    return code;
  } catch (const nlo::trainer::RunFailure& error) {
    return complain(error.what(), kRunFailed);
  } catch (const nlo::codegen::Error& error) {
    return complain(error.what(), kWrongUsage);
  } catch (const std::exception& error) {
    return complain(error.what(), kRunFailed);
  }
}
