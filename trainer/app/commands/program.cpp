// SPDX-License-Identifier: MIT
#include "trainer/app/commands/program.h"

#include <fmt/core.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <sys/ioctl.h>
#include <unistd.h>
#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "trainer/app/commands/option_facts.h"
#include "trainer/app/commands/out_of_memory.h"
#include "trainer/base/nearest_name.h"
#include "trainer/base/printable.h"

namespace nlo::trainer {
namespace {

/// CLI11's help with a wrapped right column. "INT:INT in [1 - 100]=20" is shown as "INT=20", with "1 to 100" behind the
/// description.
class HelpFormatter : public CLI::Formatter {
 public:
  explicit HelpFormatter(std::size_t width) : width_(width) {}

  std::string make_description(const CLI::App* command) const override;
  std::string make_option_opts(const CLI::Option* option) const override;
  std::string make_option_desc(const CLI::Option* option) const override;
  std::string make_subcommand(const CLI::App* command) const override;
  std::string make_footer(
      const CLI::App* command) const override;  ///< examples, which are indented, stay on their lines

 private:
  std::string right_column(const std::string& text) const;

  std::size_t width_;
};

/// Returns the columns for text on stdout: those of its terminal, otherwise COLUMNS of the environment, otherwise 100;
/// at least 60.
std::size_t help_width() {
  constexpr long kNarrowest = 60, kWidest = 1000, kUnknown = 100;
  winsize terminal{};
  long columns = 0;
  if (ioctl(fileno(stdout), TIOCGWINSZ, &terminal) == 0) columns = terminal.ws_col;
  if (const char* given = std::getenv("COLUMNS"); columns == 0 && given != nullptr)
    columns = std::strtol(given, nullptr, 10);
  return static_cast<std::size_t>(columns <= 0 ? kUnknown : std::clamp(columns, kNarrowest, kWidest));
}

/// Replaces spaces by line breaks so that no line is longer than `width`, except a single long word. Keeps the line
/// breaks of `text`.
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

constexpr int kRunFailed = 1, kWrongUsage = 2;

int complain(const char* what, int code) {
  fmt::print(stderr, "nlo: error: {}\n", printable(what));
  return code;
}

/// Returns the chosen subcommand, or the program.
CLI::App& chosen(CLI::App& app) {
  const auto commands = app.get_subcommands();
  return commands.empty() ? app : *commands.front();
}

/// Returns CLI11's message, with the nearest name for an unknown command or option.
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
    app.formatter(std::make_shared<HelpFormatter>(help_width()));  // for its commands, too
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
