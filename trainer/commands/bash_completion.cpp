// SPDX-License-Identifier: MIT
// nlo completion bash: the script, from the same tables as --help.
#include <fmt/format.h>

#include "trainer/commands/command_line.h"

namespace nlo::trainer {
namespace {

// bash puts what it offers into COMPREPLY. Whatever has no better rule gets file names.
constexpr const char* kHelpers = R"sh(_nlo_words() {
  mapfile -t COMPREPLY < <(compgen -W "$1" -- "$current")
}
_nlo_directories() {
  compopt -o filenames 2>/dev/null
  mapfile -t COMPREPLY < <(compgen -d -- "$current")
}
_nlo_files() { # SUFFIX [WORDS]
  compopt -o filenames 2>/dev/null
  mapfile -t COMPREPLY < <(compgen -f -X "!*$1" -- "$current"; compgen -d -- "$current"; compgen -W "$2" -- "$current")
}
)sh";

std::string joined(const std::vector<std::string>& words) {
  return fmt::format("{}", fmt::join(words, " "));
}

/// The shell command that completes a value; empty: bash's own, file names.
std::string rule_of(const OptionFacts& option) {
  const std::vector<std::string> words = values_of(option);
  if (option.positional == "EXPERIMENT" || option.positional == "IDENTIFICATION")
    return fmt::format("_nlo_files .toml '{}'", joined(words));
  if (option.positional == "MODEL") return "_nlo_files .json";
  if (option.positional == "KIND") return fmt::format("_nlo_files .csv '{}'", joined(words));
  if (option.value == "DIR" || option.positional == "DIR") return "_nlo_directories";
  if (!words.empty()) return fmt::format("_nlo_words '{}'", joined(words));
  return option.value == "TEXT" ? "" : ":";  // of a number nothing is known
}

std::string value_cases(const CommandFacts& command) {
  std::string cases;
  for (const OptionFacts& option : command.options) {
    if (option.names.empty() || option.value.empty()) continue;
    std::string patterns;
    for (const std::string& name : option.names)
      patterns += fmt::format("{}'{} {}'", patterns.empty() ? "" : "|", command.name, name);
    const std::string rule = rule_of(option);
    cases += fmt::format("    {}) {}return ;;\n", patterns,
                         rule.empty()  ? "compopt -o default 2>/dev/null; "
                         : rule == ":" ? ""
                                       : rule + "; ");
  }
  return cases;
}

std::string option_case(const std::string& name, const CommandFacts& command) {
  std::vector<std::string> names;
  for (const OptionFacts& option : command.options)
    for (const std::string& each : option.names)
      if (each.starts_with("--")) names.push_back(each);
  return fmt::format("      '{}') _nlo_words '{}' ;;\n", name, joined(names));
}

std::string positional_case(const CommandFacts& command) {
  for (const OptionFacts& option : command.options) {
    const std::string rule = option.positional.empty() ? "" : rule_of(option);
    if (!rule.empty()) return fmt::format("    '{}') {} ;;\n", command.name, rule);
  }
  return "";
}

}  // namespace

std::string bash_completion(const CLI::App& app) {
  std::vector<std::string> names;
  std::string values, options = option_case("", facts_of(app)), positionals;
  for (const CommandFacts& command : commands_of(app)) {
    names.push_back(command.name);
    values += value_cases(command);
    options += option_case(command.name, command);
    positionals += positional_case(command);
  }
  return fmt::format(
      "# bash completion for nlo. Printed by: nlo completion bash\n"
      "{}"
      "_nlo() {{\n"
      "  local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD - 1]}} command= i\n"
      "  COMPREPLY=()\n"
      "  for ((i = 1; i < COMP_CWORD; ++i)); do\n"
      "    [[ ${{COMP_WORDS[i]}} == -* ]] || {{ command=${{COMP_WORDS[i]}}; break; }}\n"
      "  done\n"
      "  case \"$command $previous\" in\n{}  esac\n"
      "  if [[ $current == -* ]]; then\n    case $command in\n{}    esac\n    return\n  fi\n"
      "  case $command in\n    '') _nlo_words '{}' ;;\n{}    *) compopt -o default 2>/dev/null ;;\n  esac\n"
      "}}\n"
      "complete -F _nlo nlo\n",
      kHelpers, values, options, joined(names), positionals);
}

}  // namespace nlo::trainer
