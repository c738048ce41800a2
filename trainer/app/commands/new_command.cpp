// SPDX-License-Identifier: MIT
// nlo new: writes an experiment file with comments as a start, for a plant by equations or for logs.
#include <fmt/core.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "codegen/base/identifier.h"
#include "trainer/app/commands/command.h"
#include "trainer/app/commands/experiment_templates.h"
#include "trainer/app/commands/options.h"
#include "trainer/app/commands/output_directory.h"
#include "trainer/base/number_text.h"
#include "trainer/base/printable.h"
#include "trainer/data/guess/log_guess.h"
#include "trainer/data/log_dataset.h"
#include "trainer/data/product_search.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {
namespace {

namespace fs = std::filesystem;

struct NewArguments {
  std::string kind, output;
  std::vector<std::string> files;
  LogHints hints;
  bool force = false;
};

/// Returns the name of the experiment: the name of the file as an identifier.
std::string name_of(const std::string& output) {
  if (is_stdout(output)) return "my_experiment";
  std::string name = fs::path(output).stem().string();
  for (char& c : name)
    if (!(c >= 'a' && c <= 'z') && !(c >= 'A' && c <= 'Z') && !(c >= '0' && c <= '9')) c = '_';
  return codegen::is_identifier(name) ? name : "my_experiment";
}

/// Replaces a folder by all logs in it.
std::vector<std::string> log_patterns(const std::vector<std::string>& files) {
  std::vector<std::string> patterns;
  std::error_code ignored;
  for (const std::string& file : files)
    patterns.push_back(fs::is_directory(file, ignored) ? (fs::path(file) / "*.csv").string() : file);
  return patterns;
}

std::string log_command(const NewArguments& arguments) {
  std::string command = "nlo new log";
  for (const std::string& file : arguments.files) command += " " + shell_word(file);
  if (arguments.output != "log.toml") command += " -o " + shell_word(arguments.output);
  return command;
}

/// Returns a table of the guesses, column by column.
std::string table_of(const GuessedLog& log) {
  Table table{{"column", "role", "unit", "from", "to"}};
  std::vector<std::string> why;
  for (const GuessedColumn& column : log.columns) {
    const bool has_numbers = column.low <= column.high;
    table.add_row({column.heading.empty() ? column.name : column.heading,
                   column.is_decided ? std::string(to_name(column.role)) : "?", column.unit.empty() ? "-" : column.unit,
                   has_numbers ? significant(column.low) : "-", has_numbers ? significant(column.high) : "-"});
    why.push_back(column.why);
  }
  std::string text = table.to_text(2);
  // Reasons follow their rows. The rows come after a heading and a rule.
  constexpr std::size_t kAboveRows = 2;
  std::string result;
  std::size_t line = 0;
  for (std::size_t from = 0; from < text.size(); ++line) {
    const std::size_t end = text.find('\n', from);
    result += text.substr(from, end - from);
    if (line >= kAboveRows && line - kAboveRows < why.size()) result += "  " + why[line - kAboveRows];
    result += '\n';
    from = end + 1;
  }
  return result;
}

std::string clock_text(const GuessedClock& clock) {
  if (clock.period_s == 0.0) return "no column is a time: give the time between rows with --period SECONDS\n";
  if (clock.heading.empty())
    return fmt::format("no column is a time: the time between rows is {} s\n", shortest_text(clock.period_s));
  return fmt::format("time: \"{}\" in {} ({}); a row every {} s, {}\n", clock.heading, clock.unit, clock.why,
                     significant(clock.period_s), evenness_text(clock));
}

/// Returns products of channels that help on the training logs, if the guessed roles can be read.
std::vector<FoundProduct> products_of(const std::string& text, const GuessedLog& log) {
  if (!log.undecided().empty() || log.count(ColumnRole::kOutput) == 0 || log.count(ColumnRole::kState) == 0) return {};
  if (log.train.size() < kFewestProductLogs) return {};  // before the logs are read
  try {
    const Experiment experiment = parse_draft(text, "").experiment;
    return find_products(load_logs(*experiment.log, log.directory, log.train));
  } catch (const codegen::Error&) {  // nlo train reports the error for the written file, with a better message
    return {};
  }
}

std::string gain_text(const FoundProduct& product) {
  return fmt::format("it lowers the error of a ridge regression on left-out logs by {:.0f} %", 100.0 * product.gain);
}

std::string product_text(const FoundProduct& product) {
  return fmt::format(
      "\n[[log.columns]]\nname = \"{}\"\nrole = \"output\"\nexpression = \"{}\"  # computed in flight: {}\n",
      product.name, product.expression, gain_text(product));
}

/// Returns the role without which nlo train cannot begin, in words; empty if there is one column of each.
std::string missing_role(const GuessedLog& log) {
  if (log.count(ColumnRole::kOutput) == 0)
    return "an output, but an observer reads at least one. A known voltage or command may be it: --outputs names it";
  if (log.count(ColumnRole::kState) == 0)
    return "a state, but an observer estimates at least one. --states names it; a velocity that the log does not have "
           "is a column of its own with derivative_of";
  return "";
}

void run_new_log(const NewArguments& arguments) {
  if (arguments.files.empty())
    throw codegen::Error("nlo new log: give the logs: nlo new log run1.csv run2.csv, or their folder");
  const GuessedLog log = guess_log(log_patterns(arguments.files), arguments.hints);
  const std::string command = log_command(arguments),
                    train = fmt::format("nlo train {} --data {}", shell_word(arguments.output),
                                        log.directory.empty() ? "." : shell_word(log.directory));
  std::string text = log_template(log, name_of(arguments.output), command, train);
  const std::vector<FoundProduct> products = products_of(text, log);
  for (const FoundProduct& product : products) text += product_text(product);
  run_phase([&] { write_output_file(arguments.output, text); });
  if (is_stdout(arguments.output)) return;
  std::string said = clock_text(log.clock) + "\n" + table_of(log) + "\n";
  said += fmt::format("{} rows; {} train, {} validate, {} test\n", log.rows, files_text(log.train.size()),
                      files_text(log.validation.size()), files_text(log.test.size()));
  for (const std::string& note : log.notes) said += fmt::format("note: {}\n", note);
  for (const FoundProduct& product : products)
    said += fmt::format("{} is added as a computed output: {}\n", product.expression, gain_text(product));
  const std::string missing = missing_role(log);
  if (log.undecided().empty() && !missing.empty())
    said += fmt::format("\nNo column is {}. Set the roles in {}.\n", missing, arguments.output);
  else if (!missing.empty() || !log.undecided().empty())
    said += fmt::format(
        "\nThe numbers do not show which columns are measured in flight and which are truth that only a log has. Set "
        "the\n"
        "roles in {}, or give them here:\n  {} --force --outputs A,B --inputs C --states D,E\n",
        arguments.output, command);
  said += fmt::format("\nwritten  {}; check the guesses, then:\n  {}\n", arguments.output, train);
  fmt::print("{}", printable(said));
}

void run_new(NewArguments arguments) {
  const bool is_log = arguments.kind == "log";
  if (!is_log && (!arguments.files.empty() || !arguments.hints.states.empty() || !arguments.hints.outputs.empty() ||
                  !arguments.hints.inputs.empty() || arguments.hints.period_s > 0.0))
    throw codegen::Error("nlo new plant: accepts no logs and no columns; for logs write nlo new log FILE.csv");
  if (arguments.output.empty()) arguments.output = is_log ? "log.toml" : "plant.toml";
  check_output_file(arguments.output);
  std::error_code ignored;
  if (!is_stdout(arguments.output) && !arguments.force && fs::exists(arguments.output, ignored))
    throw codegen::Error(fmt::format("{}: already exists; write another file with -o FILE, or replace it with --force",
                                     arguments.output));
  if (is_log) return run_new_log(arguments);
  run_phase([&] { write_output_file(arguments.output, plant_template(name_of(arguments.output), arguments.output)); });
  if (!is_stdout(arguments.output))
    fmt::print(
        "written  {0}: a pendulum, which you can replace by your plant; to train it as it is:\n  nlo train {1}\n",
        arguments.output, shell_word(arguments.output));
}

}  // namespace

void add_new(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<NewArguments>();
  CLI::App* command = app.add_subcommand("new", "Write a first experiment file for a plant or for logs");
  Options options(*command);
  options.value("KIND", arguments->kind, "plant: a template with equations; log: guesses from the FILES")
      ->required()
      ->check(CLI::IsMember({"plant", "log"}));
  options.value("FILES", arguments->files, "log: CSV files of one rig, or their folder");
  options.value("-o,--output", arguments->output, "file to write (plant.toml, log.toml); - for stdout");
  options.list("--outputs", arguments->hints.outputs, "log: columns that are measured in flight", "COLUMN,...");
  options.list("--inputs", arguments->hints.inputs, "log: columns that the controller commands or knows in flight",
               "COLUMN,...");
  options.list("--states", arguments->hints.states, "log: columns of the truth, which the observer estimates",
               "COLUMN,...");
  options.value("--period", arguments->hints.period_s, "log: seconds between rows, if no column is a time", "SECONDS")
      ->check(CLI::PositiveNumber);
  options.flag("--force", arguments->force, "replace the file");
  command->footer(
      "Roles, units, wraps of angles, the clock, separators and a split into training, validation and test are guessed "
      "from headings and numbers. The reason for each guess is printed and written into the file.\n"
      "Examples:\n"
      "  nlo new plant -o pendulum.toml\n"
      "  nlo new log logs/run*.csv -o rig.toml\n"
      "  nlo new log logs --outputs gyro,acc --inputs motor --states angle,rate -o rig.toml");
  command->callback([arguments, &action] { action = [arguments] { run_new(*arguments); }; });
}

}  // namespace nlo::trainer
