// SPDX-License-Identifier: MIT
// nlo replay: replays a recorded flight with the arithmetic of the export that was used in it.
#include <fmt/core.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/model_file/model_file.h"
#include "trainer/app/commands/command.h"
#include "trainer/app/commands/options.h"
#include "trainer/app/commands/output_directory.h"
#include "trainer/app/replay/compare_flight.h"
#include "trainer/app/replay/flight_log.h"
#include "trainer/app/replay/flown_export.h"
#include "trainer/base/printable.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;

struct ReplayArguments {
  std::string model, log, output;
  Flown flown;
  std::vector<std::string> columns;
  bool warm_start = false;
};

std::vector<std::pair<std::string, std::string>> headings_of(const std::vector<std::string>& columns) {
  std::vector<std::pair<std::string, std::string>> headings;
  for (const std::string& text : columns) {
    const std::size_t at = text.find('=');
    if (at == 0 || at == std::string::npos || at + 1 == text.size())
      throw codegen::Error(fmt::format("--column {}: expected NAME=HEADING, such as --column x1_hat=est_pos", text));
    headings.emplace_back(text.substr(0, at), text.substr(at + 1));
  }
  return headings;
}

double seconds_before(const FlightLog& log, double sample_period_s, Index row) {
  double time_s = 0.0;
  for (Index k = 1; k <= row; ++k)
    time_s += log.given(kGivenCommand, k) == kStepOverDt ? log.given(kGivenDt, k) : sample_period_s;
  return time_s;
}

std::string difference_text(const FlightLog& log, const FlightComparison& compare, const FlightDifference& difference,
                            const Eigen::MatrixXd& answers, double sample_period_s, bool single) {
  const LoggedColumn& column = *difference.column;
  const double logged = column.values[difference.row], answer = answers(column.answer, difference.row);
  const std::string where = fmt::format("{}:{}: row {}, {:.6g} s after the first: {} ", log.file,
                                        log.lines[static_cast<std::size_t>(difference.row)], difference.row + 1,
                                        seconds_before(log, sample_period_s, difference.row), column.heading);
  const std::string rows = fmt::format("; {} of {} rows differ\n", difference.rows, log.given.cols());
  if (column.answer == kAnswerStatus)
    return where + fmt::format("was {}, replayed {}", status_word(logged), status_word(answer)) + rows;
  if (column.answer == kAnswerInDomain) return where + fmt::format("was {}, replayed {}", logged, answer) + rows;
  return where +
         fmt::format("was {}, replayed {}: the difference is {:.9g} units in the last place",
                     all_digits(logged, single), all_digits(answer, single), compare.units(logged, answer)) +
         rows;
}

void write_answers(const std::string& output, const codegen::Model& model, const Eigen::MatrixXd& answers,
                   bool single) {
  std::string text;
  for (const codegen::Channel& state : model.states) text += state.name + "_hat,";
  text += "status,in_domain\n";
  for (Index k = 0; k < answers.cols(); ++k) {
    for (Index i = kAnswerEstimate; i < answers.rows(); ++i) text += all_digits(answers(i, k), single) + ",";
    text += fmt::format("{},{}\n", status_word(answers(kAnswerStatus, k)), answers(kAnswerInDomain, k));
  }
  run_phase([&] { write_output_file(output, text); });
}

void run_replay(const ReplayArguments& arguments) {
  const auto headings = headings_of(arguments.columns);
  if (!arguments.output.empty()) check_output_file(arguments.output);
  const codegen::Model model = codegen::read_model(arguments.model);
  FlightLog log = read_flight(arguments.log, model, arguments.flown.scalar == "double" ? 8 : 4, headings);
  const FlownExport flown(model, arguments.flown);
  if (arguments.warm_start && !flown.settles())
    throw codegen::Error(fmt::format("--warm-start: {} has no warm_start() in {}", arguments.model, flown.name()));
  if (arguments.warm_start) log.given(kGivenCommand, 0) += kWarmStart;
  const Eigen::MatrixXd answers = flown.run(log.given);
  if (!arguments.output.empty()) write_answers(arguments.output, model, answers, flown.single());

  const FlightComparison compare(log, flown.single());
  std::vector<std::string> compared;
  for (const LoggedColumn& column : log.answers) compared.push_back(column.heading);
  std::string report = fmt::format("{}: {} rows of {}, {}; compared: {}\n", log.file, log.given.cols(), model.name,
                                   flown.name(), fmt::join(compared, ", "));
  if (!log.missing.empty()) report += fmt::format("not in the log: {}\n", fmt::join(log.missing, ", "));
  const std::optional<FlightDifference> difference = compare.first(answers);
  if (const Index rounded = compare.rounded(answers); rounded > 0) {
    std::vector<std::string> digits;
    for (const LoggedColumn& column : log.answers)
      if (column.digits > 0) digits.push_back(fmt::format("{} {}", column.heading, column.digits));
    report += fmt::format("{} numbers were compared with the digits of the log (digits: {}); %.{}g prints all digits\n",
                          rounded, fmt::join(digits, ", "), compare.digits_needed());
    if (!difference) report += "the same, to the digits of the log\n";
  } else if (!difference) {
    report += "the same, bit for bit\n";
  }
  auto* const to = is_stdout(arguments.output) && !arguments.output.empty() ? stderr : stdout;
  if (difference) report += difference_text(log, compare, *difference, answers, model.sample_period_s, flown.single());
  fmt::print(to, "{}", printable(report));
  if (difference)
    throw RunFailure(
        fmt::format("{} differs from the results of {} (first difference above)", log.file, arguments.model));
}

}  // namespace

void add_replay(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<ReplayArguments>();
  CLI::App* command =
      app.add_subcommand("replay", "Reproduce a recorded flight bit for bit, or print the first difference");
  Options options(*command);
  options.value("MODEL", arguments->model, "model.json of the export that flew")->required();
  options
      .value("LOG", arguments->log,
             "CSV with a row for each step: the arguments of step(), NAME_hat of each state, and optionally dt, status "
             "and in_domain")
      ->required();
  options.shown("--target", arguments->flown.target,
                "target of the export that flew: c99 (also for the single header and the deterministic policy), or cpp "
                "(the fast policy, whose bits depend on processor, compiler and flags)");
  options.shown("--scalar", arguments->flown.scalar, "--scalar of that export: float, double or int16");
  options.shown("--weights", arguments->flown.weights, "--weights of that export (cpp): float, bf16 or fp16");
  options.value("--max-error", arguments->flown.max_error, "--max-error of that export (cpp)", "VALUE");
  options.value("--compiler", arguments->flown.compiler,
                "compiler and flags (default: cc -O1 for c99, c++ -O2 for cpp)", "WORDS");
  options.repeated("--column", arguments->columns, "heading of a reading, an estimate, dt or status in the log",
                   "NAME=HEADING");
  options.flag("--warm-start", arguments->warm_start, "the first row was the argument of warm_start()");
  options.value("-o,--output", arguments->output, "write the estimates of the replay as CSV; - for stdout");
  command->footer(
      "Examples:\n"
      "  nlo replay model.json flight.csv\n"
      "  nlo replay model.json flight.csv --scalar int16 --column x2_hat=velocity -o again.csv\n"
      "Exit codes: 0 if all bits agree, 1 if they differ, 2 for wrong usage or input, or without a compiler.");
  command->callback([arguments, &action] { action = [arguments] { run_replay(*arguments); }; });
}

}  // namespace nlo::trainer
