// SPDX-License-Identifier: MIT
#include "trainer/commands/help_formatter.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <sstream>

#include "trainer/commands/command_line.h"

namespace nlo::trainer {

std::size_t help_width() {
  constexpr long kNarrowest = 60, kWidest = 1000, kUnknown = 100;
  winsize terminal{};
  long columns = 0;
  if (ioctl(fileno(stdout), TIOCGWINSZ, &terminal) == 0) columns = terminal.ws_col;
  if (const char* given = std::getenv("COLUMNS"); columns == 0 && given != nullptr)
    columns = std::strtol(given, nullptr, 10);
  return static_cast<std::size_t>(columns <= 0 ? kUnknown : std::clamp(columns, kNarrowest, kWidest));
}

std::string wrapped(const std::string& text, std::size_t width) {
  std::string result;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (!result.empty()) result += '\n';
    std::size_t used = 0;
    std::istringstream words(line);
    for (std::string word; words >> word;) {
      if (used > 0) {
        const bool fits = used + 1 + word.size() <= width;
        result += fits ? ' ' : '\n';
        used = fits ? used + 1 : 0;
      }
      result += word;
      used += word.size();
    }
  }
  return result;
}

std::string HelpFormatter::right_column(const std::string& text) const {
  return wrapped(text, width_ > column_width_ ? width_ - column_width_ : 1);
}

std::string HelpFormatter::make_description(const CLI::App* command) const {
  const std::string text = CLI::Formatter::make_description(command);
  return text.empty() ? "" : wrapped(text, width_) + "\n";
}

std::string HelpFormatter::make_option_opts(const CLI::Option* option) const {
  const OptionFacts facts = facts_of(*option);
  if (facts.value.empty()) return "";
  std::string text = " " + facts.value;
  if (!facts.fallback.empty()) text += "=" + facts.fallback;
  if (facts.repeats) text += " ...";
  return facts.required ? text + " REQUIRED" : text;
}

std::string HelpFormatter::make_option_desc(const CLI::Option* option) const {
  const OptionFacts facts = facts_of(*option);
  std::string text = facts.description;
  if (!facts.range.empty()) text += fmt::format("; {}", facts.range);
  if (!facts.members.empty()) text += fmt::format("; one of {}", fmt::join(facts.members, ", "));
  return right_column(text);
}

std::string HelpFormatter::make_subcommand(const CLI::App* command) const {
  std::ostringstream out;
  CLI::detail::format_help(out, command->get_display_name(true), right_column(command->get_description()),
                           column_width_);
  return out.str();
}

std::string HelpFormatter::make_footer(const CLI::App* command) const {
  std::string result;
  std::istringstream lines(command->get_footer());
  for (std::string line; std::getline(lines, line);)
    result += (line.starts_with(' ') ? line : wrapped(line, width_)) + "\n";
  return result;
}

}  // namespace nlo::trainer
