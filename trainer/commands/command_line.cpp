// SPDX-License-Identifier: MIT
#include "trainer/commands/command_line.h"

#include <fmt/core.h>

#include <algorithm>
#include <memory>

#include "codegen/targets/registry.h"
#include "trainer/base/version.h"
#include "trainer/commands/command.h"
#include "trainer/experiments/load_identification.h"
#include "trainer/experiments/shipped.h"
#include "trainer/reproduce/registry.h"

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

/// "1 to 100" of "INT in [1 - 100]", CLI11's name of the type of a number in a range.
std::string range_in(const std::string& type) {
  const auto open = type.find(" in ["), middle = type.find(" - ", open), close = type.find(']', open);
  if (open == std::string::npos || middle == std::string::npos || close == std::string::npos || middle > close)
    return "";
  return fmt::format("{} to {}", type.substr(open + 5, middle - open - 5), type.substr(middle + 3, close - middle - 3));
}

}  // namespace

OptionFacts facts_of(const CLI::Option& option) {
  OptionFacts facts;
  for (const std::string& name : option.get_snames()) facts.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) facts.names.push_back("--" + name);
  if (facts.names.empty()) facts.positional = option.get_name(true);
  const std::string type = option.get_type_name();
  if (option.get_items_expected_max() > 0) facts.value = type.substr(0, type.find(':'));
  facts.members = members_in(type);
  facts.range = range_in(type);
  facts.fallback = option.get_default_str();
  facts.required = option.get_required();
  facts.repeats = option.get_expected_max() == CLI::detail::expected_max_vector_size;
  facts.description = option.get_description();
  return facts;
}

std::vector<std::string> values_of(const OptionFacts& option) {
  std::vector<std::string> words = option.members;
  const auto is = [&](const char* name) {
    return option.positional == name || std::find(option.names.begin(), option.names.end(), name) != option.names.end();
  };
  if (is("EXPERIMENT"))
    for (const ShippedExperiment& experiment : shipped_experiments()) words.emplace_back(experiment.name);
  if (is("IDENTIFICATION"))
    for (const ShippedExperiment& identification : shipped_identifications()) words.emplace_back(identification.name);
  if (is("--target"))
    for (const codegen::ExportTarget& target : codegen::export_targets()) words.emplace_back(target.name);
  if (is("WHAT")) {
    words = {"all", "example1", "example2", "example3"};
    for (const reproduction::Item& item : reproduction::items()) words.emplace_back(item.name);
  }
  return words;
}

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
  command->callback([&app, &action] { action = [&app] { fmt::print("{}", man_page(app, kVersion)); }; });
}

void add_completion(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("completion", "Print a script that completes commands in a shell");
  auto shell = std::make_shared<std::string>();
  command->add_option("SHELL", *shell, "which shell")->required()->check(CLI::IsMember({"bash", "zsh"}));
  command->footer(
      "Examples (an installed nlo is completed without):\n"
      "  source <(nlo completion bash)        in ~/.bashrc\n"
      "  source <(nlo completion zsh)         in ~/.zshrc, after compinit");
  command->callback([&app, &action, shell] {
    action = [&app, shell] { fmt::print("{}", *shell == "zsh" ? zsh_completion(app) : bash_completion(app)); };
  });
}

}  // namespace nlo::trainer
