// SPDX-License-Identifier: MIT
// nlo identify: finds the parameters of a plant by expressions from logs, with standard errors, and the errors of
// filters with the identified plant on the test logs. Also writes the experiment that trains an observer with this
// plant.
#include <fmt/core.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "codegen/base/file.h"
#include "trainer/app/commands/command.h"
#include "trainer/app/commands/options.h"
#include "trainer/app/commands/output_directory.h"
#include "trainer/app/commands/patient_progress.h"
#include "trainer/app/jobs/run_jobs.h"
#include "trainer/base/nearest_name.h"
#include "trainer/base/parallel.h"
#include "trainer/base/printable.h"
#include "trainer/data/log_dataset.h"
#include "trainer/data/log_schema.h"
#include "trainer/experiments/load_identification.h"
#include "trainer/experiments/prior_experiment.h"
#include "trainer/identify/identification_text.h"
#include "trainer/identify/identified_filter.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {
namespace {

struct IdentifyArguments {
  std::string experiment, data, output;
  std::vector<std::string> overrides;
  int threads = -1;
  bool no_filters = false, json = false, force = false, help_config = false;
};

constexpr const char *kResultFile = "identified.json", *kPriorFile = "prior.toml";

/// Reads a file, or an experiment in the program by its name.
Identification read_argument(const IdentifyArguments& arguments) {
  std::vector<std::string> overrides = arguments.overrides;
  if (arguments.threads >= 0) overrides.push_back(fmt::format("threads={}", arguments.threads));
  std::error_code ignored;
  if (std::filesystem::exists(arguments.experiment, ignored) &&
      !std::filesystem::is_directory(arguments.experiment, ignored))
    return read_identification(arguments.experiment, overrides);
  std::vector<std::string> names;
  for (const ShippedExperiment& shipped : shipped_identifications()) {
    if (shipped.name == arguments.experiment)
      return parse_identification(shipped.text, arguments.experiment + ".toml", overrides);
    names.emplace_back(shipped.name);
  }
  const std::string nearest = nearest_name(arguments.experiment, names);
  throw codegen::Error(fmt::format("{}: no such file, and no identification of that name; {}", arguments.experiment,
                                   nearest.empty() ? fmt::format("there are: {}", fmt::join(names, ", "))
                                                   : fmt::format("did you mean \"{}\"?", nearest)));
}

/// Throws rather than replace a file of another identification.
void check_result_file(const std::string& file, const std::string& name, bool force) {
  std::error_code ignored;
  if (force || !std::filesystem::exists(file, ignored)) return;
  const auto found = nlohmann::json::parse(codegen::read_file(file), nullptr, false);
  const std::string owner = found.is_object() ? found.value("identification", "") : "";
  if (owner == name) return;
  throw codegen::Error(fmt::format(
      "{}: {}; choose another directory with -o DIR, or replace it with --force", file,
      owner.empty() ? "is not a result of an identification" : "holds the result of another identification, " + owner));
}

/// Returns a line for the user if one filter may settle at a wrong angle, else nothing.
std::string note_about_hidden_angles(const Identification& identification) {
  std::vector<std::string> names;
  for (const HiddenAngle& angle : hidden_angles(identification, resolve_columns(identification.log).state_channels))
    names.push_back(identification.plant.states[static_cast<std::size_t>(angle.state)]);
  if (names.empty()) return {};
  return fmt::format(
      "note: no output measures {0}, which may start anywhere. This observer is one filter, and one filter may settle\n"
      "      at a wrong angle and stay there. The EKF and the UKF of this program start several times around {0}.\n"
      "      Also train an observer from the logs alone, without [plant] and structure, and compare both on test "
      "logs.\n",
      fmt::join(names, " and "));
}

/// Writes the experiment of a prior. Returns lines for the user: the command that trains it, or the reason why there is
/// no file. A file with another text, which a user may have edited, is kept unless `force` is set.
std::string write_prior(const std::string& file, const Identification& identification,
                        const IdentificationResult& result, const IdentifyArguments& arguments) {
  std::string text;
  try {
    text = prior_experiment(identification, result.values, arguments.data);
  } catch (const codegen::Error& error) {
    return fmt::format("no experiment with structure = \"prior\" is written: {}\n", error.what());
  }
  std::string train = fmt::format("nlo train {}", shell_word(file));
  if (!arguments.data.empty()) train += fmt::format(" --data {}", shell_word(arguments.data));
  text = fmt::format(
      "# An observer that steps the equations of the identification \"{}\": a Kalman filter that is tuned on the\n"
      "# training logs. nlo train lets it learn corrections if the errors on left-out logs are then smaller by a "
      "tenth;\n"
      "# `units = 0` in [observer] keeps the filter, `units = 16` the corrections. Written by nlo identify.\n{}",
      identification.name, text);
  std::error_code ignored;
  if (!arguments.force && std::filesystem::exists(file, ignored) && codegen::read_file(file) != text)
    return fmt::format("kept: {}, because it has been changed; --force replaces it\n", file);
  codegen::write_file_atomically(file, text);
  return fmt::format("written: {}, an observer that steps these equations. Train it with\n  {}\n{}", file, train,
                     note_about_hidden_angles(identification));
}

void run_identify(const IdentifyArguments& arguments) {
  const Identification identification = read_argument(arguments);
  const std::string directory = arguments.output.empty() ? "runs/" + identification.name : arguments.output;
  const std::string file = directory + "/" + kResultFile;
  check_output_directory(directory);
  check_result_file(file, identification.name, arguments.force);

  const LogSchema schema = resolve_columns(identification.log);
  LogSplits splits = load_log_splits(identification.log, arguments.data);
  const std::atomic<bool>& stop = stop_on_interrupt();
  ThreadPool pool(identification.threads);
  PatientProgress progress;
  const IdentificationResult result = run_phase([&] {
    return identify(identification, splits.train, splits.test, pool, &stop, [&](int iteration, double deviation) {
      progress.update(static_cast<double>(iteration) / identification.identify.iterations,
                      fmt::format("iteration {}: residuals {} deviations", iteration, significant(deviation)));
    });
  });
  std::optional<FilterStudy> study;
  if (!arguments.no_filters && !result.stopped)
    study = run_phase([&] {
      return study_filters(identification, result.values, splits, schema, pool, &stop,
                           [&](double share, const std::string& what) { progress.update(share, what); });
    });
  progress.finish();

  const std::string json = identification_json(identification.name, result, study ? &*study : nullptr);
  std::string prior;
  run_phase([&] {
    make_output_directory(directory);
    codegen::write_file_atomically(file, json);
    if (!result.stopped) prior = write_prior(directory + "/" + kPriorFile, identification, result, arguments);
  });
  if (arguments.json) {
    fmt::print("{}", json);
  } else {
    fmt::print("{}", printable(fmt::format("{}: {}", identification.name, to_text(result))));
    if (study) fmt::print("\n{}", printable(to_text(*study)));
    fmt::print("\nwritten: {}\n{}", file, printable(prior));
  }
  if (stop.load()) throw RunFailure("interrupted: the parameters are the best so far; run it again to finish");
}

}  // namespace

void add_identify(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<IdentifyArguments>();
  CLI::App* command = app.add_subcommand(
      "identify", "Find a plant's parameters from logs, with standard errors, and test an EKF and a UKF that use them");
  Options options(*command);
  options.value("IDENTIFICATION", arguments->experiment,
                "file with [plant], [log] and [identify], or the name of a shipped one");
  options.directory("--data", arguments->data, "directory of the logs that [log] names");
  options.directory("-o,--output", arguments->output,
                    "directory for identified.json and prior.toml (default: runs/NAME)");
  options.changes(arguments->overrides);
  options.value("--threads", arguments->threads, "number of threads; 0: all cores; does not affect the result")
      ->check(CLI::Range(0, 1024));
  options.flag("--no-filters", arguments->no_filters, "only find the parameters, without a test of filters");
  options.flag("--json", arguments->json, "print identified.json instead of tables");
  options.flag("--force", arguments->force, "replace the results of another identification in the directory");
  options.flag("--help-config", arguments->help_config, "list the keys of [identify] with their defaults and stop");
  std::string names;
  for (const ShippedExperiment& shipped : shipped_identifications())
    names += (names.empty() ? "" : ", ") + std::string(shipped.name);
  command->footer(fmt::format(
      "The method of Levenberg and Marquardt fits the parameters so that simulations of the plant agree with segments "
      "of the training logs. Each segment has an initial state of its own. There are two standard errors: s^2 "
      "(J'J)^-1, and one by segments, which allows for correlated residuals within a segment.\n"
      "Then these filters estimate the states of the test logs: an EKF and a UKF with the identified plant, a Kalman "
      "filter with constant acceleration, and baselines that need no plant. Q, R and P0 of EKF and UKF are tuned on "
      "the validation logs, or on the training logs if there are none. If an angle is not measured and may start "
      "anywhere, several filters start around the circle, and their innovations weight them. The table also counts the "
      "operations and functions (sin, tanh, powers, square roots) of a step: those of the expressions at 2 n_x + 1 "
      "points by RK4, and those of the filter's matrices.\n"
      "prior.toml is an experiment for nlo train: an observer that steps the identified plant (structure = "
      "\"prior\").\n"
      "If a state is in no column or an output is a function of an input, the file is not written, and a line gives "
      "the reason.\n"
      "Shipped: {}.\n"
      "Examples:\n"
      "  nlo identify qube --data logs\n"
      "  nlo identify mine.toml --data logs --set identify.segment_s=0.5 --no-filters",
      names));
  command->callback([arguments, &action] {
    if (!arguments->help_config && arguments->experiment.empty()) throw CLI::RequiredError("IDENTIFICATION");
    action = [arguments] {
      if (arguments->help_config) return fmt::print("{}", describe_identify_keys());
      run_identify(*arguments);
    };
  });
}

}  // namespace nlo::trainer
