// SPDX-License-Identifier: MIT
// nlo man, nlo-reproduce --man: the manual page from the same tables as --help.
#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>

#include "trainer/base/version.h"
#include "trainer/commands/command.h"
#include "trainer/commands/command_line.h"

namespace nlo::trainer {
namespace {

/// Text that stands for itself in roff: backslashes, hyphens that are typed as such, lines that begin like a request.
std::string roff(const std::string& text) {
  std::string result;
  bool line_begins = true;
  for (const char c : text) {
    if (line_begins && (c == '.' || c == '\'')) result += "\\&";
    if (c == '\\')
      result += "\\e";
    else if (c == '-')
      result += "\\-";
    else
      result += c;
    line_begins = c == '\n';
  }
  return result;
}

/// As it stands, line by line.
std::string verbatim(const std::string& text) {
  return text.empty() ? "" : fmt::format(".PP\n.nf\n{}\n.fi\n", roff(text));
}

std::string heading_of(const OptionFacts& option) {
  if (!option.positional.empty()) return fmt::format("\\fI{}\\fR", roff(option.positional));
  std::string names;
  for (const std::string& name : option.names)
    names += fmt::format("{}\\fB{}\\fR", names.empty() ? "" : ", ", roff(name));
  return option.value.empty() ? names : fmt::format("{} \\fI{}\\fR", names, roff(option.value));
}

std::string options_text(const CommandFacts& command) {
  std::string text;
  for (const OptionFacts& option : command.options) {
    text += fmt::format(".TP\n{}\n{}", heading_of(option), roff(option.description));
    if (!option.members.empty()) text += roff(fmt::format("; one of {}", fmt::join(option.members, ", ")));
    if (!option.fallback.empty()) text += roff(fmt::format(" (default: {})", option.fallback));
    if (option.required && option.positional.empty()) text += " (required)";
    text += "\n";
  }
  return text;
}

std::string synopsis_of(const std::string& name, const CommandFacts& command) {
  std::string text = fmt::format("\\fB{}\\fR [\\fIOPTIONS\\fR]", roff(name));
  for (const OptionFacts& option : command.options)
    if (!option.positional.empty()) text += fmt::format(" \\fI{}\\fR", roff(option.positional));
  return text;
}

}  // namespace

std::string man_page(const CLI::App& app) {
  const CommandFacts program = facts_of(app);
  const std::vector<CommandFacts> commands = commands_of(app);
  const auto synopsis = [&](const CommandFacts& command) {
    return synopsis_of(program.name + " " + command.name, command);
  };
  std::string page = program.name;  // "nlo reproduce" is the program nlo-reproduce
  std::replace(page.begin(), page.end(), ' ', '-');
  std::string title = page;
  std::transform(page.begin(), page.end(), title.begin(), [](unsigned char c) { return std::toupper(c); });
  std::string text = fmt::format(
      ".\\\" Printed by the program.\n.TH {} 1 \"\" \"nlo {}\" \"User Commands\"\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n",
      roff(title), roff(kVersion), roff(page), roff(program.description));
  if (commands.empty()) text += synopsis_of(program.name, program) + "\n";
  for (const CommandFacts& command : commands)
    text += fmt::format("{}\n{}", synopsis(command), &command == &commands.back() ? "" : ".br\n");
  text += fmt::format(".SH DESCRIPTION\n{}\n.SH OPTIONS\n{}", roff(program.description), options_text(program));
  if (!commands.empty()) text += ".SH COMMANDS\n";
  for (const CommandFacts& command : commands)
    text += fmt::format(".SS {}\n{}.\n{}{}", synopsis(command), roff(command.description), options_text(command),
                        verbatim(command.footer));
  return text + ".SH NOTES\n" + verbatim(program.footer);
}

void add_man(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("man", "Print the manual page, nlo(1)");
  command->footer(
      "Example:\n"
      "  nlo man | man -l -");
  command->callback([&app, &action] { action = [&app] { fmt::print("{}", man_page(app)); }; });
}

}  // namespace nlo::trainer
