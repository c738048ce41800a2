// SPDX-License-Identifier: MIT
// nlo train: writes model.json, metrics.csv and report.html from an experiment.
#include <fmt/core.h>
#include <fmt/format.h>

#include <memory>
#include <string>
#include <tuple>

#include "codegen/base/file.h"
#include "codegen/model_file/model_file.h"
#include "trainer/app/commands/command.h"
#include "trainer/app/commands/feedback_rounds.h"
#include "trainer/app/commands/input_facts.h"
#include "trainer/app/commands/options.h"
#include "trainer/app/commands/run_data.h"
#include "trainer/app/commands/run_folder.h"
#include "trainer/app/commands/run_report.h"
#include "trainer/app/commands/train_auto.h"
#include "trainer/app/commands/train_command.h"
#include "trainer/base/printable.h"
#include "trainer/config/experiment.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/shipped.h"
#include "trainer/learn/training/train.h"

namespace nlo::trainer {
namespace {

/// Returns true if the training continues from a checkpoint in the folder.
bool goes_on(const TrainArguments& arguments, const RunFolder& folder) {
  if (!arguments.resume || folder.can_resume()) return arguments.resume;
  if (!arguments.quiet) fmt::print(stderr, "{}: there is nothing to resume, so the training starts\n", folder.path());
  return false;
}

void write_derived(const Experiment& experiment, const RunFolder& folder) {
  codegen::write_file_atomically(
      folder.path() + "/derived.toml",
      "# Keys that the experiment left out are derived from its data: nlo train derived.toml gives the same model.\n" +
          experiment.source_text);
}

/// Throws RunFailure if there is no model yet: the training was interrupted while the readout was chosen by trainings
/// without some of the logs.
void require_model(const TrainingResult& result, const std::string& resume_command) {
  if (result.outcome == TrainOutcome::kInterrupted && result.model.states.empty())
    throw RunFailure(
        fmt::format("interrupted in {}; to continue with the same bytes: {}", result.message, resume_command));
}

KnownFacts known_facts(const Experiment& experiment, const RunData& data) {
  KnownFacts facts;
  facts.ignored_inputs = ignored_inputs(experiment);
  if (!experiment.log) return facts;
  facts.input_delay = input_delay(*experiment.log, data.training.sample_period_s);
  facts.training_logs = to_text(data.remembered);
  return facts;
}

void write_model(const codegen::Model& model, bool quiet, const RunFolder& folder) {
  if (!quiet) fmt::print(stderr, "{}", printable(ignored_inputs_note(model)));
  codegen::write_model(model, folder.path() + "/model.json");
}

/// Throws RunFailure if the training was interrupted; its model is the best so far.
void require_end(const TrainingResult& result, int steps, const RunFolder& folder, const std::string& resume_command) {
  if (result.outcome == TrainOutcome::kInterrupted)
    throw RunFailure(
        fmt::format("interrupted after {} of {} steps; {}/model.json has the best model so far; to continue with the "
                    "same bytes: {}",
                    result.steps_done, steps, folder.path(), resume_command));
}

RunReport judge(const Experiment& experiment, const RunData& data, const TrainingResult& result) {
  const auto measure = [&] {
    if (experiment.log) return report_on_logs(result.model, experiment, data.training, data.reported(), data.clock);
    StudyTest test;
    test.seed = experiment.seed;
    test.threads = experiment.threads;
    return report_on_plant(result.model, experiment, test);
  };
  RunReport report = measure();
  if (is_chosen(experiment.inverse_map.readout)) report.readout = result.readout;
  report.readout_by_settled = experiment.inverse_map.readout == ReadoutChoice::kSettled;
  report.groups = result.groups;
  if (!result.succeeded()) report.warning = result.message;
  return report;
}

/// Prints and writes the report. Writes finished.json last, because it means that all files are written. Throws
/// RunFailure if the training failed.
void write_end(const TrainingResult& result, const RunReport& report, FinishedRun run, const RunFolder& folder) {
  fmt::print("{}", printable(run_report_text(result.model, report)));
  write_run_report(result.model, report, folder.path());
  run.failure = report.warning;
  write_finished_run(folder.path(), run);
  fmt::print("model    {0}/model.json\nmetrics  {0}/metrics.csv\nreport   {0}/report.html\n", folder.path());
  if (!result.succeeded()) throw RunFailure(result.message);
  if (!result.message.empty()) fmt::print("note     {}\n", printable(result.message));
}

}  // namespace

DraftExperiment draft_to_train(const TrainArguments& arguments) {
  if (arguments.experiment.experiment.empty())
    throw codegen::Error("EXPERIMENT is missing; write nlo train FILE.toml, or a shipped name such as van_der_pol");
  DraftExperiment draft = read_draft(arguments.experiment);
  if (draft.experiment.plant && !arguments.data.empty())
    throw codegen::Error("--data is for experiments with a [log]; this one simulates its [plant]");
  return draft;
}

void carry_out(const DraftExperiment& draft, const TrainArguments& arguments, const RunFolder& folder) {
  PreparedRun run = read_logs(draft, arguments.data, arguments.quiet);
  const FinishedRun identity{run_identity(draft.experiment), logs_fingerprint(run)};
  if (arguments.resume && folder.holds(identity)) return fmt::print("{}: already done\n", folder.path());
  const bool resume = goes_on(arguments, folder);
  simulate_and_derive(draft, arguments.data, arguments.quiet, run);
  print_warnings(run.data.warnings);
  const std::string resume_command = fmt::format(
      "nlo train {} -o {} --resume", command_words(arguments.experiment, arguments.data), shell_word(folder.path()));
  run_phase([&] {
    if (run.derived) write_derived(run.experiment, folder);
    const TrainingResult result =
        run_rounds(run.experiment, run.data, folder, {resume, arguments.quiet, known_facts(run.experiment, run.data)});
    require_model(result, resume_command);
    write_model(result.model, arguments.quiet, folder);
    require_end(result, run.experiment.training.steps, folder, resume_command);
    const RunReport report = judge(run.experiment, run.data, result);
    write_end(result, report, identity, folder);
  });
}

void run_train(const TrainArguments& arguments) {
  const DraftExperiment draft = draft_to_train(arguments);
  const std::string output = arguments.output.empty() ? "runs/" + draft.experiment.name : arguments.output;
  const RunFolder folder(output, draft.experiment, arguments.force);
  carry_out(draft, arguments, folder);
}

void add_train(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<TrainArguments>();
  CLI::App* command = app.add_subcommand("train", "Train an observer from a plant or from logs");
  Options options(*command);
  options.value("EXPERIMENT", arguments->experiment.experiment, "experiment file, or the name of a shipped one");
  options.directory("--data", arguments->data, "directory of the logs that [log] names");
  options.directory("-o,--output", arguments->output,
                    "directory for model.json, metrics.csv and report.html (default: runs/NAME)");
  options.flag("--resume", arguments->resume,
               "continue from the checkpoint in the directory, which gives the same bytes as an uninterrupted run; "
               "without a checkpoint, start; if the run is finished, do nothing");
  auto budget = std::make_shared<SearchBudget>();
  auto searching = std::make_shared<bool>(false);
  CLI::Option* automatic =
      options.flag("--auto", *searching,
                   "search for a better experiment by varying structure, eigenvalues, units, widths and learning rate");
  options.value("--minutes", budget->minutes, "--auto: minutes for the search and the training (default: 10)")
      ->check(check_minutes)
      ->needs(automatic);
  for (const auto& [name, to, meaning] :
       {std::tuple{"--max-multiply-adds", &budget->multiply_adds,
                   "--auto: largest number of multiply-adds of a step and an estimate"},
        {"--max-flash-bytes", &budget->flash_bytes, "--auto: largest number of bytes of constants, in float"}})
    options.value(name, *to, meaning)->check(CLI::Range(std::int64_t{1}, std::int64_t{1} << 31))->needs(automatic);
  options.flag("--force", arguments->force, "replace the model of another experiment");
  options.experiment(arguments->experiment);
  options.flag("-q,--quiet", arguments->quiet, "no progress on stderr");
  auto help_config = std::make_shared<bool>(false);
  options.flag("--help-config", *help_config, "list every key of an experiment file");
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
      if (*help_config)
        fmt::print("{}", describe_experiment_keys());
      else if (*searching)
        run_train_auto(*arguments, *budget);
      else
        run_train(*arguments);
    };
  });
}

}  // namespace nlo::trainer
