// SPDX-License-Identifier: MIT
// nlo train: experiment -> model.json, metrics.csv, report.html.
#include <fmt/core.h>
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <tuple>
#include <utility>

#include "codegen/base/file.h"
#include "codegen/model_file/model_file.h"
#include "trainer/app/commands/command.h"
#include "trainer/app/commands/directory_lock.h"
#include "trainer/app/commands/input_facts.h"
#include "trainer/app/commands/options.h"
#include "trainer/app/commands/output_directory.h"
#include "trainer/app/commands/run_report.h"
#include "trainer/app/commands/train_auto.h"
#include "trainer/app/commands/train_command.h"
#include "trainer/app/commands/training_data.h"
#include "trainer/app/jobs/kept_training.h"
#include "trainer/app/jobs/run_jobs.h"
#include "trainer/app/terminal/progress.h"
#include "trainer/base/number_text.h"
#include "trainer/base/printable.h"
#include "trainer/choose/left_out.h"
#include "trainer/config/experiment.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/shipped.h"
#include "trainer/experiments/training_sets.h"
#include "trainer/learn/training/checkpoint.h"
#include "trainer/learn/training/provenance.h"
#include "trainer/learn/training/train.h"

namespace nlo::trainer {
namespace {

class RoundDirectories {
 public:
  RoundDirectories(std::string output, const Experiment& experiment)
      : output_(std::move(output)), last_(experiment.feedback ? experiment.feedback->rounds : 0) {}

  int last() const { return last_; }

  std::string of(int round) const { return round == last_ ? output_ : output_ + "/round_" + std::to_string(round); }

  /// Whether a round has a checkpoint.
  bool begun(int round) const { return has_checkpoint(of(round)); }

  /// Removes checkpoints of another run, which a resumed one would take for its own.
  void forget() const {
    std::error_code ignored;
    for (int round = 0; last_ > 0 && round <= last_; ++round)
      std::filesystem::remove(of(round) + "/checkpoint.bin", ignored);
  }

 private:
  std::string output_;
  int last_;
};

/// What the rmse of the progress is of, where the states' units do not add up.
void say_units(const Experiment& experiment, const Dataset& training) {
  if (experiment.loss.is_normalised())
    fmt::print(stderr, "rmse: of each state over its standard deviation, as the loss is\n");
  else if (!share_a_unit(training.states))
    fmt::print(stderr,
               "rmse: adds up states of different units as they are, as the loss does; [loss] scale = "
               "\"normalised\" weighs the states alike\n");
}

TrainingResult train_with_progress(const Experiment& experiment, const RunData& data, const TrainArguments& arguments,
                                   const std::string& directory, bool resume) {
  std::optional<ProgressDisplay> display;
  if (!arguments.quiet) {
    say_units(experiment, data.training);
    display.emplace(stderr);
  }
  TrainOptions options;
  options.directory = directory;
  options.resume = resume;
  options.stop = &stop_on_interrupt();
  if (display) options.progress = [&](const TrainProgress& progress) { display->update(progress); };
  const TrainingBegins begins = [&](const std::string& what) {
    if (!display) return;
    display->finish();
    fmt::print(stderr, "{}\n", printable(what));
    display.emplace(stderr);
  };
  TrainingResult result = train_by_groups(experiment, data.training, data.validation, options, begins);
  if (display) display->finish();
  if (result.returns > 0 && !arguments.quiet)
    fmt::print(
        stderr,
        "note: training ran away {} time{} and went on from its best; a lower learning_rate (now {}) may keep it\n",
        result.returns, result.returns == 1 ? "" : "s", shortest_text(experiment.training.learning_rate));
  return result;
}

/// What spoils a training, whether anybody wants to see its progress or not.
void warn(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) fmt::print(stderr, "warning: {}\n", printable(warning));
}

/// All rounds of an experiment: one without [feedback].
TrainingResult train_rounds(const Experiment& experiment, RunData& data, const TrainArguments& arguments) {
  const RoundDirectories rounds(arguments.output, experiment);
  if (!arguments.resume) rounds.forget();
  TrainingResult result;
  for (int round = 0; round <= rounds.last(); ++round) {
    if (round > 0) {
      TrainingSets sets = next_round(experiment, {round, &result.model}, {std::move(data.training), {}});
      data.training = std::move(sets.training);
      data.validation = std::move(sets.validation);
      warn(sets.warnings);
    }
    if (rounds.last() > 0 && !arguments.quiet)
      fmt::print(stderr, "round {} of {}: {} runs, in the loop of {}\n", round, rounds.last(),
                 data.training.trajectories.size(),
                 round == 0 ? "the true state" : fmt::format("round {}'s observer", round - 1));
    result = train_with_progress(experiment, data, arguments, rounds.of(round),
                                 arguments.resume && (rounds.last() == 0 || rounds.begun(round)));
    if (result.outcome == TrainOutcome::kInterrupted || result.outcome == TrainOutcome::kDiverged) return result;
  }
  return result;
}

RunReport judge(const Experiment& experiment, const RunData& data, const codegen::Model& model) {
  if (experiment.log) return report_on_logs(model, experiment, data.training, data.judged, data.clock);
  StrictTest test;
  test.seed = experiment.seed;
  test.threads = experiment.threads;
  return report_on_plant(model, experiment, test);
}

std::string resume_command(const TrainArguments& arguments) {
  return fmt::format("nlo train {} -o {} --resume", command_words(arguments.experiment, arguments.data),
                     shell_word(arguments.output));
}

/// Whether the directory holds the end of this very run: then there is nothing to do. Throws RunFailure again for one
/// that failed.
bool already_done(const TrainArguments& arguments, const FinishedRun& run) {
  const auto found = read_finished_run(arguments.output);
  if (!found || found->experiment != run.experiment || found->data != run.data) return false;
  if (!found->failure.empty()) throw RunFailure(fmt::format("{}: {}", arguments.output, found->failure));
  fmt::print("{}: already done\n", arguments.output);
  return true;
}

}  // namespace

void run_train(TrainArguments arguments) {
  if (arguments.help_config) {
    fmt::print("{}", describe_experiment_keys());
    return;
  }
  if (arguments.experiment.experiment.empty())
    throw codegen::Error("EXPERIMENT is missing; write nlo train FILE.toml, or a shipped name such as van_der_pol");
  const DraftExperiment draft = read_draft(arguments.experiment);
  Experiment experiment = draft.experiment;
  if (experiment.plant && !arguments.data.empty())
    throw codegen::Error("--data is for experiments with a [log]; this one simulates its [plant]");
  if (arguments.output.empty()) arguments.output = "runs/" + experiment.name;
  DirectoryLock lock;
  lock.take(arguments.output);
  FinishedRun run{run_identity(experiment)};
  if (arguments.resume && experiment.plant && already_done(arguments, run)) return;
  const bool has_begun = RoundDirectories(arguments.output, experiment).begun(0) || begun_by_groups(arguments.output);
  check_output_directory({arguments.output, arguments.resume && !has_begun, arguments.force}, experiment.name);
  if (arguments.resume && !has_begun && !has_checkpoint(arguments.output)) {
    arguments.resume = false;
    if (!arguments.quiet) fmt::print(stderr, "{}: there is nothing to resume; it begins\n", arguments.output);
  }
  PreparedRun prepared = prepare_run(draft, arguments.data, arguments.quiet);
  RunData& data = prepared.data;
  experiment = std::move(prepared.experiment);
  if (experiment.log) {
    run.data = data_fingerprint(data.validation, data_fingerprint(data.training, fingerprint(nullptr, 0)));
    if (arguments.resume && already_done(arguments, run)) return;
  }

  warn(data.warnings);
  run_phase([&] {
    make_output_directory(arguments.output);
    lock.take(arguments.output);
    check_output_directory({arguments.output, false, arguments.force}, experiment.name);  // another may have been there
    if (prepared.derived)
      codegen::write_file_atomically(
          arguments.output + "/derived.toml",
          "# What the experiment left out was derived from its data: nlo train derived.toml trains the same.\n" +
              experiment.source_text);
    TrainingResult result = train_rounds(experiment, data, arguments);
    if (result.outcome == TrainOutcome::kInterrupted && result.model.states.empty())
      throw RunFailure(fmt::format("interrupted in {}; this goes on to the same bytes: {}", result.message,
                                   resume_command(arguments)));
    if (experiment.log) result.model.provenance.emplace_back(kTrainingLogsFact, to_text(data.remembered));
    record_ignored_inputs(experiment, result.model);
    record_input_delays(experiment, result.model);
    if (!arguments.quiet) fmt::print(stderr, "{}", printable(ignored_inputs_note(result.model)));
    codegen::write_model(result.model, arguments.output + "/model.json");
    if (result.outcome == TrainOutcome::kInterrupted)
      throw RunFailure(fmt::format(
          "interrupted after {} of {} steps; {}/model.json has the best so far, and this goes on to the same bytes: {}",
          result.steps_done, experiment.training.steps, arguments.output, resume_command(arguments)));
    RunReport report = judge(experiment, data, result.model);
    if (experiment.inverse_map.readout == ReadoutChoice::kSelected) report.readout = result.readout;
    report.groups = result.groups;
    if (!result.succeeded()) report.warning = result.message;
    fmt::print("{}", printable(run_report_text(result.model, report)));
    write_run_report(result.model, report, arguments.output);
    run.failure = report.warning;
    write_finished_run(arguments.output, run);
    fmt::print("model    {0}/model.json\nmetrics  {0}/metrics.csv\nreport   {0}/report.html\n", arguments.output);
    if (!result.succeeded()) throw RunFailure(result.message);
    if (!result.message.empty()) fmt::print("note     {}\n", printable(result.message));
  });
}

void add_train(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<TrainArguments>();
  CLI::App* command = app.add_subcommand("train", "Learn an observer from a plant or from logs");
  Options options(*command);
  options.value("EXPERIMENT", arguments->experiment.experiment, "experiment file, or the name of a shipped one");
  options.directory("--data", arguments->data, "directory of the logs that [log] names");
  options.directory("-o,--output", arguments->output,
                    "directory for model.json, metrics.csv and report.html (default: runs/NAME)");
  options.flag("--resume", arguments->resume,
               "continue from the directory's checkpoint, to the same bytes; start if there is none, do nothing if the "
               "run is finished");
  auto budget = std::make_shared<SearchBudget>();
  auto searching = std::make_shared<bool>(false);
  CLI::Option* automatic = options.flag(
      "--auto", *searching,
      "search for a better experiment near this one: structure, eigenvalues, units, widths, learning rate");
  options.value("--minutes", budget->minutes, "--auto: minutes for the search and the training (default: 10)")
      ->check(check_minutes)
      ->needs(automatic);
  for (const auto& [name, to, meaning] :
       {std::tuple{"--max-multiply-adds", &budget->multiply_adds,
                   "--auto: most multiply-adds of a step and an estimate"},
        {"--max-flash-bytes", &budget->flash_bytes, "--auto: most bytes of constants, in float"}})
    options.value(name, *to, meaning)->check(CLI::Range(std::int64_t{1}, std::int64_t{1} << 31))->needs(automatic);
  options.flag("--force", arguments->force, "replace another experiment's model");
  options.experiment(arguments->experiment);
  options.flag("-q,--quiet", arguments->quiet, "no progress on stderr");
  options.flag("--help-config", arguments->help_config, "list every key of an experiment file");
  std::string shipped;
  for (const ShippedExperiment& experiment : shipped_experiments())
    shipped += fmt::format("{}{}", shipped.empty() ? "" : ", ", experiment.name);
  command->footer(
      fmt::format("Shipped experiments: {}\n"
                  "Examples:\n"
                  "  nlo train van_der_pol -o runs/first\n"
                  "  nlo train my_rig.toml --data logs/ --set training.steps=2000 --seed 3\n"
                  "  nlo train van_der_pol -o runs/first --resume\n"
                  "  nlo train my_rig.toml --data logs/ --auto --minutes 20 --max-multiply-adds 3000",
                  shipped));
  command->callback([=, &action] {
    action = [=] {
      if (*searching)
        run_train_auto(*arguments, *budget);
      else
        run_train(*arguments);
    };
  });
}

}  // namespace nlo::trainer
