// SPDX-License-Identifier: MIT
// nlo completion zsh: the script, from the same tables as --help.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "trainer/commands/command_line.h"

namespace nlo::trainer {
namespace {

/// Text for a single-quoted word of zsh in which `special` have a meaning to _arguments or _describe.
std::string quoted(const std::string& text, const std::string& special) {
  std::string result;
  for (const char c : text) {
    if (c == '\'') {
      result += "'\\''";
      continue;
    }
    if (special.find(c) != std::string::npos) result += '\\';
    result += c;
  }
  return result;
}

/// The action of _arguments that completes a value; " ": nothing is known of it.
std::string action_of(const OptionFacts& option) {
  const std::vector<std::string> words = values_of(option);
  if (option.positional == "EXPERIMENT" || option.positional == "IDENTIFICATION")
    return fmt::format("_alternative \"names\\:name\\:({})\" \"files\\:file\\:_files -g '\\''*.toml'\\''\"",
                       fmt::join(words, " "));
  if (option.positional == "MODEL") return "_files -g \"*.json\"";
  if (option.value == "DIR" || option.positional == "DIR") return "_files -/";
  if (!words.empty()) return fmt::format("({})", fmt::join(words, " "));
  const bool may_be_a_file = option.value == "TEXT" || option.value.starts_with("FILE");
  return may_be_a_file ? "_files" : " ";
}

/// The arguments of _arguments for an option or a positional argument.
std::string spec_of(const OptionFacts& option) {
  const std::string description = quoted(option.description, "\\[]:"),
                    value =
                        fmt::format(":{}:{}", quoted(option.value.empty() ? option.positional : option.value, "\\:"),
                                    action_of(option));
  if (!option.positional.empty())
    return fmt::format("        '{}:{}:{}'", option.repeats ? "*" : "", quoted(option.positional, "\\:"),
                       action_of(option));
  std::string specs;
  for (const std::string& name : option.names) {
    const std::string others = option.repeats ? "*" : fmt::format("({})", fmt::join(option.names, " "));
    specs += fmt::format("{}        '{}{}[{}]{}'", specs.empty() ? "" : " \\\n", others, name, description,
                         option.value.empty() ? "" : value);
  }
  return specs;
}

std::string specs_of(const CommandFacts& command) {
  std::string text;
  for (const OptionFacts& option : command.options) text += " \\\n" + spec_of(option);
  return text;
}

}  // namespace

std::string zsh_completion(const CLI::App& app) {
  std::string names, cases;
  for (const CommandFacts& command : commands_of(app)) {
    names += fmt::format("        '{}:{}'\n", command.name, quoted(command.description, "\\:"));
    cases += fmt::format("      {}) _arguments -s{} ;;\n", command.name, specs_of(command));
  }
  return fmt::format(
      "#compdef nlo\n"
      "# zsh completion for nlo. Printed by: nlo completion zsh\n"
      "_nlo() {{\n"
      "  local curcontext=$curcontext context state state_descr line\n"
      "  typeset -A opt_args\n"
      "  _arguments -C{} \\\n"
      "        '1: :->command' '*:: :->arguments' && return\n"
      "  case $state in\n"
      "    command)\n"
      "      local -a commands=(\n{}      )\n"
      "      _describe -t commands 'command' commands ;;\n"
      "    arguments) case $words[1] in\n{}      esac ;;\n"
      "  esac\n"
      "}}\n"
      "if [[ $funcstack[1] == _nlo ]]; then _nlo \"$@\"; else compdef _nlo nlo; fi\n",
      specs_of(facts_of(app)), names, cases);
}

}  // namespace nlo::trainer
