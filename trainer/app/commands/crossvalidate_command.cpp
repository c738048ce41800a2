// SPDX-License-Identifier: MIT
// nlo crossvalidate: tests an observer of logs on logs, days and conditions that were not in its training. Each log, or
// each group of logs, is left out once; training uses only the others.
#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "trainer/app/commands/command.h"
#include "trainer/app/commands/crossvalidate_text.h"
#include "trainer/app/commands/experiment_argument.h"
#include "trainer/app/commands/options.h"
#include "trainer/app/commands/output_directory.h"
#include "trainer/app/commands/patient_progress.h"
#include "trainer/app/jobs/kept_training.h"
#include "trainer/app/jobs/run_jobs.h"
#include "trainer/base/printable.h"
#include "trainer/choose/left_out.h"
#include "trainer/choose/recipe.h"
#include "trainer/data/log_dataset.h"
#include "trainer/data/log_delays.h"
#include "trainer/data/log_files.h"
#include "trainer/data/log_schema.h"
#include "trainer/data/transient.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/mirrored_channels.h"
#include "trainer/judge/evaluation/evaluate_logs.h"
#include "trainer/judge/evaluation/metrics.h"
#include "trainer/learn/training/provenance.h"

namespace nlo::trainer {
namespace {

struct CrossvalidateArguments {
  ExperimentArgument experiment;
  std::string data, group, output;
  std::vector<int> sizes;
  int seeds = 1;
  bool json = false;
};

std::vector<std::string> all_files(const LogConfig& log, const std::string& directory) {
  const SplitFiles splits = expand_splits(log, directory);
  std::vector<std::string> files = splits.train;
  files.insert(files.end(), splits.validation.begin(), splits.validation.end());
  files.insert(files.end(), splits.test.begin(), splits.test.end());
  std::sort(files.begin(), files.end());
  return files;
}

/// Draws `count` of `others`; the draw depends only on the seed. Returns all of them if `count` is 0.
std::vector<std::string> chosen(std::vector<std::string> others, int count, unsigned long long seed) {
  if (count == 0 || static_cast<std::size_t>(count) >= others.size()) return others;
  std::uint64_t state = seed + 1;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {  // Fisher and Yates, from the front
    state = state * 6364136223846793005U + 1442695040888963407U;
    std::swap(others[i], others[i + (state >> 33) % (others.size() - i)]);
  }
  others.resize(static_cast<std::size_t>(count));
  std::sort(others.begin(), others.end());
  return others;
}

/// Returns the part of `data` that the experiment trains on. `data` may be large, so it is copied into `own` only if a
/// transient is cut off.
const Dataset& trained_on(const Dataset& data, const Experiment& experiment, Dataset& own) {
  if (experiment.training.transient != Transient::kDrop) return data;
  own = data;
  drop_transient(own, transient_time_s(experiment.observer, experiment.training.transient_factor));
  return own;
}

/// Trains on `training`, or finds the training in a folder of `root`, and evaluates the model on the fold.
JobEnd judge_fold(const LogGroup& fold, const std::vector<std::string>& training, DraftExperiment draft,
                  const std::string& root, const JobContext& context, FoldOutcome& outcome) {
  Experiment& experiment = draft.experiment;
  experiment.threads = context.threads;
  experiment.log->train_files = training;
  experiment.log->validation_files.clear();
  experiment.log->test_files = fold.files;
  find_log_delays(*experiment.log, "", experiment.observer.input_hold);  // from the training logs of this fold only
  const LogSplits splits = load_log_splits(*experiment.log, "", mirrored_channels(experiment));
  // If there are few logs, two folds may have the same training logs; the name distinguishes their trainings.
  experiment.source_text += "# without " + fold.name + "\n";
  const FinishedRun inputs{run_identity(experiment), data_fingerprint(splits.train, fingerprint(nullptr, 0))};
  Dataset own;
  const TrainingWork work = [&](const TrainOptions& options) {
    experiment.source_text = format_experiment(experiment);
    const Experiment complete =
        draft.complete ? experiment : derive_recipe(draft, splits.train, splits.train).experiment;
    const Dataset& data = trained_on(splits.train, complete, own);
    return train_with_folds(complete, data, data, options);
  };
  codegen::Model model;
  const JobEnd end = load_or_train(root.empty() ? "" : kept_folder(root, inputs), inputs, context, work, model);
  if (end == JobEnd::kStopped) return end;
  const Experiment trained = experiment_of(model, fold.name);
  const Dataset& data = trained_on(splits.train, trained, own);
  const LogEvaluation evaluation =
      evaluate_on_logs(model, splits.test, resolve_columns(*experiment.log), &data, NoiseConfig{}, experiment.seed,
                       metrics_config(trained, splits.test));
  outcome = {fold.name, static_cast<int>(training.size()), experiment.seed, {}};
  for (const LogEntry& entry : evaluation.entries) outcome.errors[entry.estimator] = entry.metrics.pooled;
  return end;
}

std::string command_line(const CrossvalidateArguments& arguments) {
  std::string text = "nlo crossvalidate " + command_words(arguments.experiment, arguments.data);
  if (!arguments.group.empty()) text += " --group " + shell_word(arguments.group);
  if (!arguments.sizes.empty()) text += fmt::format(" --logs {}", fmt::join(arguments.sizes, ","));
  if (arguments.seeds > 1) text += fmt::format(" --seeds {}", arguments.seeds);
  return text + (arguments.json ? " --json -o " : " -o ") + shell_word(arguments.output);
}

void run_crossvalidate(const CrossvalidateArguments& arguments) {
  const DraftExperiment draft = read_draft(arguments.experiment);
  const Experiment& experiment = draft.experiment;
  if (!experiment.log)
    throw codegen::Error(
        "crossvalidate needs an experiment with a [log], but this one simulates its [plant]; use nlo evaluate");
  std::optional<OutputDirectory> directory;
  if (!arguments.output.empty()) directory.emplace(arguments.output);
  const std::vector<std::string> files = all_files(*experiment.log, arguments.data);
  const std::string pattern = arguments.group.empty() ? experiment.validation.groups : arguments.group;
  const std::vector<LogGroup> folds =
      log_groups(files, pattern, arguments.group.empty() ? "[validation] groups" : "--group");
  if (folds.size() < 2)
    throw codegen::Error(fmt::format("{} log{} in {} group; crossvalidation needs at least two groups", files.size(),
                                     files.size() == 1 ? "" : "s", folds.size()));
  std::size_t fewest = files.size();
  for (const LogGroup& fold : folds) fewest = std::min(fewest, files.size() - fold.files.size());
  for (const int size : arguments.sizes) {
    if (std::ranges::count(arguments.sizes, size) > 1)
      throw codegen::Error(fmt::format("--logs {}: is given twice", size));
    if (size < 1 || static_cast<std::size_t>(size) > fewest)
      throw codegen::Error(fmt::format("--logs {}: the number of training logs must be from 1 to {}", size, fewest));
  }

  const std::vector<int> sizes = arguments.sizes.empty() ? std::vector<int>{0} : arguments.sizes;
  std::vector<FoldOutcome> outcomes(sizes.size() * folds.size() * static_cast<std::size_t>(arguments.seeds));
  std::vector<Job> jobs;
  for (const int size : sizes)
    for (const LogGroup& fold : folds)
      for (int s = 0; s < arguments.seeds; ++s) {
        DraftExperiment seeded = draft;
        seeded.experiment.seed += static_cast<unsigned long long>(s);
        std::vector<std::string> others;
        std::set_difference(files.begin(), files.end(), fold.files.begin(), fold.files.end(),
                            std::back_inserter(others));
        others = chosen(std::move(others), size, seeded.experiment.seed);
        jobs.push_back({"without " + fold.name, static_cast<double>(others.size()),
                        [=, &arguments, &outcome = outcomes[jobs.size()]](const JobContext& context) {
                          return judge_fold(fold, others, seeded, arguments.output, context, outcome);
                        }});
      }
  run_phase([&] {
    StatusLine line;
    if (arguments.output.empty()) line.log_after(kPatience);
    JobsProgress progress(line);
    const JobsResult result =
        run_jobs(jobs, {.threads = experiment.threads, .stop = &stop_on_interrupt(), .progress = &progress});
    line.finish();
    result.check();
    if (result.left > 0)
      throw RunFailure(result.interrupted_text(arguments.output.empty() ? "" : command_line(arguments)));
  });
  if (arguments.json) return fmt::print("{}", crossvalidation_json(outcomes));
  fmt::print(
      "{}: {} {} left out one by one, {} training{} each; alternatives fitted on the same training logs\n"
      "(products: a ridge regression on the last three samples and their products)\n\n",
      experiment.name, folds.size(), pattern.empty() ? "logs" : "groups of logs", arguments.seeds,
      arguments.seeds == 1 ? "" : "s of other seeds");
  fmt::print("{}", printable(arguments.sizes.empty() ? fold_table(outcomes, folds, arguments.seeds)
                                                     : curve_table(outcomes, arguments.sizes)));
}

}  // namespace

void add_crossvalidate(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<CrossvalidateArguments>();
  CLI::App* command =
      app.add_subcommand("crossvalidate", "Leave each log, or each group of logs, out of the training once");
  Options options(*command);
  options.value("EXPERIMENT", arguments->experiment.experiment, "experiment file, or the name of a shipped one")
      ->required();
  options.directory("--data", arguments->data, "directory of the logs that [log] names: all splits together");
  options.value("--group", arguments->group,
                "regular expression: logs with the same match in their names are left out together (default: "
                "[validation] groups)",
                "REGEX");
  options.list("--logs", arguments->sizes,
               "learning curve: number of training logs, drawn from the other logs; a row for each number", "COUNT");
  options.number("--seeds", arguments->seeds, 1, 100,
                 "number of trainings for each left-out log or group; their seeds count up from the experiment's seed");
  options.experiment(arguments->experiment);
  options.directory("-o,--output", arguments->output,
                    "directory that keeps each training, so that an interrupted run can be continued");
  options.flag("--json", arguments->json, "one JSON array instead of tables: an object for each training");
  command->footer(
      "Without -o, nothing is written. Each training selects its model by the error on its training logs.\n"
      "Examples:\n"
      "  nlo crossvalidate battery --data logs --group \"^n?[0-9]+degC\" --seeds 3\n"
      "  nlo crossvalidate mine.toml --data logs\n"
      "  nlo crossvalidate mine.toml --data logs --logs 2,4,8");
  command->callback([arguments, &action] { action = [arguments] { run_crossvalidate(*arguments); }; });
}

}  // namespace nlo::trainer
