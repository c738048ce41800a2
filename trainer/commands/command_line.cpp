// SPDX-License-Identifier: MIT
#include "trainer/commands/command_line.h"

#include <fmt/core.h>

#include <algorithm>

#include "trainer/commands/command.h"

namespace nlo::trainer {
namespace {

/// The words of "TEXT:{ekf,constant}", CLI11's name of the type of an option that takes only those.
std::vector<std::string> members_in(const std::string& type) {
  const auto open = type.find('{'), close = type.rfind('}');
  std::vector<std::string> members;
  if (open == std::string::npos || close == std::string::npos) return members;
  for (std::size_t start = open + 1; start < close;) {
    const std::size_t end = std::min(type.find(',', start), close);
    members.push_back(type.substr(start, end - start));
    start = end + 1;
  }
  return members;
}

OptionFacts facts_of(const CLI::Option& option) {
  OptionFacts facts;
  for (const std::string& name : option.get_snames()) facts.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) facts.names.push_back("--" + name);
  if (facts.names.empty()) facts.positional = option.get_name(true);
  const std::string type = option.get_type_name();
  if (option.get_items_expected_max() > 0) facts.value = type.substr(0, type.find(':'));
  facts.members = members_in(type);
  facts.fallback = option.get_default_str();
  facts.required = option.get_required();
  facts.description = option.get_description();
  return facts;
}

}  // namespace

CommandFacts facts_of(const CLI::App& app) {
  CommandFacts facts{app.get_name(), app.get_description(), app.get_footer(), {}};
  for (const CLI::Option* option : app.get_options()) facts.options.push_back(facts_of(*option));
  return facts;
}

std::vector<CommandFacts> commands_of(const CLI::App& app) {
  std::vector<CommandFacts> commands;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    commands.push_back(facts_of(*command));
  return commands;
}

void add_man(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("man", "Print the manual page, nlo(1)");
  command->footer(
      "Example:\n"
      "  nlo man | man -l -");
  command->callback([&app, &action] { action = [&app] { fmt::print("{}", man_page(app, NLO_VERSION)); }; });
}

void add_completion(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("completion", "Print a script that completes commands in a shell");
  command->add_option("SHELL", "which shell")->required()->check(CLI::IsMember({"bash"}));
  command->footer(
      "Example:\n"
      "  source <(nlo completion bash)        (in ~/.bashrc; an installed nlo is completed without)");
  command->callback([&app, &action] { action = [&app] { fmt::print("{}", bash_completion(app)); }; });
}

}  // namespace nlo::trainer
