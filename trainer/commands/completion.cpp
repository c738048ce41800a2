// SPDX-License-Identifier: MIT
// nlo completion: the values that are offered, and which script.
#include <fmt/core.h>

#include <algorithm>
#include <memory>

#include "codegen/targets/registry.h"
#include "trainer/commands/command.h"
#include "trainer/commands/command_line.h"
#include "trainer/experiments/load_identification.h"
#include "trainer/experiments/shipped.h"

namespace nlo::trainer {

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
  if (is("WHAT")) words = {"all", "example1", "example2", "example3"};  // nlo reproduce --help lists the others
  return words;
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
