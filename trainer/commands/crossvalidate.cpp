// SPDX-License-Identifier: MIT
// nlo crossvalidate: how an observer of logs fares on logs, days and conditions that it was not trained on. Each log, or
// each group of them, is left out once; training sees the others alone.
#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "trainer/base/printable.h"
#include "trainer/commands/command.h"
#include "trainer/commands/experiment_argument.h"
#include "trainer/commands/patient_progress.h"
#include "trainer/data/log_dataset.h"
#include "trainer/data/log_delays.h"
#include "trainer/data/log_files.h"
#include "trainer/data/log_groups.h"
#include "trainer/data/log_schema.h"
#include "trainer/data/transient.h"
#include "trainer/evaluation/evaluate_logs.h"
#include "trainer/evaluation/metrics_config.h"
#include "trainer/evaluation/text.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/recipe/recipe.h"
#include "trainer/training/left_out.h"

namespace nlo::trainer {
namespace {

struct CrossvalidateArguments {
  ExperimentArgument experiment;
  std::string data, group;
  std::vector<int> sizes;
  int seeds = 1;
  bool json = false;
};

/// What one training on `logs` logs gave on a fold.
struct Outcome {
  std::string fold;
  int logs = 0;
  unsigned long long seed = 0;
  std::map<std::string, std::vector<StateError>> errors;  ///< by estimator, over all samples of the fold
};

struct Alternative {
  const char *estimator, *heading;
};
constexpr Alternative kAlternatives[] = {
    {"sensor", "sensor"}, {"ridge", "ridge"}, {"static_ridge", "products"}, {"constant", "constant"}};

std::vector<std::string> all_files(const LogConfig& log, const std::string& directory) {
  const SplitFiles splits = expand_splits(log, directory);
  std::vector<std::string> files = splits.train;
  files.insert(files.end(), splits.validation.begin(), splits.validation.end());
  files.insert(files.end(), splits.test.begin(), splits.test.end());
  std::sort(files.begin(), files.end());
  return files;
}

/// `count` of the others, the same for a seed; all of them where count is 0.
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

Outcome outcome_of(DraftExperiment draft, const LogGroup& fold, std::vector<std::string> training) {
  Experiment& experiment = draft.experiment;
  experiment.log->train_files = training;
  experiment.log->validation_files.clear();
  experiment.log->test_files = fold.files;
  find_log_delays(*experiment.log, "", experiment.observer.input_hold);  // of these logs alone
  experiment.source_text = format_experiment(experiment);
  LogSplits splits = load_log_splits(*experiment.log, "", experiment.training.mirror);
  if (!draft.complete) experiment = derive_recipe(draft, splits.train, splits.train).experiment;
  if (experiment.training.transient == Transient::kDrop)
    drop_transient(splits.train, transient_time_s(experiment.observer, experiment.training.transient_factor));
  const TrainingResult result = train_by_groups(experiment, splits.train, splits.train, {});
  if (result.outcome == TrainOutcome::kDiverged) throw codegen::Error(result.message);
  const LogEvaluation evaluation =
      evaluate_on_logs(result.model, splits.test, resolve_columns(*experiment.log), &splits.train, NoiseConfig{},
                       experiment.seed, metrics_config(experiment, splits.test));
  Outcome outcome{fold.name, static_cast<int>(training.size()), experiment.seed, {}};
  for (const LogEntry& entry : evaluation.entries) outcome.errors[entry.estimator] = entry.metrics.pooled;
  return outcome;
}

struct OverLogs {
  double mean = 0.0, deviation = 0.0, worst = 0.0;
};

OverLogs over_logs(const std::vector<double>& values) {
  OverLogs all;
  for (const double value : values) {
    all.mean += value / static_cast<double>(values.size());
    all.worst = std::max(value, all.worst);
  }
  all.deviation = deviation_of(values).value_or(0.0);
  return all;
}

/// NaN where the estimator does not apply.
double rmse(const Outcome& outcome, const char* estimator, std::size_t state) {
  const auto found = outcome.errors.find(estimator);
  return found == outcome.errors.end() ? std::nan("") : found->second[state].rmse.front();
}

/// A row for each fold, the mean over seeds; below it all folds together. `logs`: of the outcomes to show.
std::string fold_table(const std::vector<Outcome>& outcomes, const std::vector<LogGroup>& folds, int seeds) {
  std::string text;
  const std::vector<StateError>& states = outcomes.front().errors.at("observer");
  for (std::size_t i = 0; i < states.size(); ++i) {
    std::vector<std::string> headings = {"RMSE of " + with_unit(states[i].name, states[i].unit) + ", left out", "logs",
                                         seeds > 1 ? "observer ± over seeds" : "observer"};
    for (const Alternative& other : kAlternatives) headings.emplace_back(other.heading);
    Table table{std::move(headings)};
    std::vector<double> all;
    std::vector<std::vector<double>> others(std::size(kAlternatives));
    for (const LogGroup& fold : folds) {
      std::vector<double> own;
      const Outcome* last = nullptr;
      for (const Outcome& outcome : outcomes)
        if (outcome.fold == fold.name) {
          own.push_back(rmse(outcome, "observer", i));
          last = &outcome;
        }
      all.push_back(over_logs(own).mean);
      std::vector<std::string> row = {fold.name, std::to_string(fold.files.size()),
                                      to_text(Spread{all.back(), deviation_of(own)})};
      for (std::size_t a = 0; a < others.size(); ++a) {
        others[a].push_back(rmse(*last, kAlternatives[a].estimator, i));
        row.push_back(significant(others[a].back()));
      }
      table.add_row(std::move(row));
    }
    table.add_rule();
    const auto row = [&](const std::string& name, double OverLogs::*what) {
      std::vector<std::string> cells = {name, "", significant(over_logs(all).*what)};
      for (const std::vector<double>& each : others) cells.push_back(significant(over_logs(each).*what));
      table.add_row(std::move(cells));
    };
    row("mean", &OverLogs::mean);
    row("deviation over folds", &OverLogs::deviation);
    row("worst", &OverLogs::worst);
    text += (i == 0 ? "" : "\n") + table.to_text(2);
  }
  return text;
}

/// A row for each number of training logs: mean over folds and seeds.
std::string curve_table(const std::vector<Outcome>& outcomes, const std::vector<int>& sizes) {
  std::vector<std::string> headings = {"training logs"};
  const std::vector<StateError>& states = outcomes.front().errors.at("observer");
  for (const StateError& state : states) {
    headings.push_back(with_unit(state.name, state.unit));
    headings.push_back("ridge");
  }
  Table table{std::move(headings)};
  for (const int size : sizes) {
    std::vector<std::string> row = {std::to_string(size)};
    for (std::size_t i = 0; i < states.size(); ++i) {
      std::vector<double> own, ridge;
      for (const Outcome& outcome : outcomes)
        if (outcome.logs == size) {
          own.push_back(rmse(outcome, "observer", i));
          ridge.push_back(rmse(outcome, "ridge", i));
        }
      row.push_back(significant(over_logs(own).mean));
      row.push_back(significant(over_logs(ridge).mean));
    }
    table.add_row(std::move(row));
  }
  return table.to_text(2);
}

std::string json_of(const std::vector<Outcome>& outcomes) {
  nlohmann::ordered_json array = nlohmann::ordered_json::array();
  for (const Outcome& outcome : outcomes) {
    nlohmann::ordered_json entry = {
        {"left_out", outcome.fold}, {"training_logs", outcome.logs}, {"seed", outcome.seed}};
    const std::vector<StateError>& states = outcome.errors.at("observer");
    for (std::size_t i = 0; i < states.size(); ++i) {
      nlohmann::ordered_json& of_state = entry["rmse"][states[i].name];
      of_state["observer"] = rmse(outcome, "observer", i);
      for (const Alternative& other : kAlternatives)
        if (const double error = rmse(outcome, other.estimator, i); std::isfinite(error))
          of_state[other.estimator] = error;
    }
    array.push_back(std::move(entry));
  }
  return array.dump(2) + "\n";
}

void run_crossvalidate(const CrossvalidateArguments& arguments) {
  const DraftExperiment draft = read_draft(arguments.experiment);
  const Experiment& experiment = draft.experiment;
  if (!experiment.log)
    throw codegen::Error("crossvalidate is about logs, and this experiment simulates its [plant]; use nlo evaluate");
  const std::vector<std::string> files = all_files(*experiment.log, arguments.data);
  const std::string pattern = arguments.group.empty() ? experiment.validation.groups : arguments.group;
  const std::vector<LogGroup> folds =
      log_groups(files, pattern, arguments.group.empty() ? "[validation] groups" : "--group");
  if (folds.size() < 2)
    throw codegen::Error(fmt::format("{} log{} in {} group; crossvalidation needs two groups at least", files.size(),
                                     files.size() == 1 ? "" : "s", folds.size()));
  std::size_t fewest = files.size();
  for (const LogGroup& fold : folds) fewest = std::min(fewest, files.size() - fold.files.size());
  for (const int size : arguments.sizes)
    if (size < 1 || static_cast<std::size_t>(size) > fewest)
      throw codegen::Error(fmt::format("--logs {}: between 1 and {} are left to train on", size, fewest));

  const std::vector<int> sizes = arguments.sizes.empty() ? std::vector<int>{0} : arguments.sizes;
  const std::size_t total = sizes.size() * folds.size() * static_cast<std::size_t>(arguments.seeds);
  PatientProgress progress;
  std::vector<Outcome> outcomes;
  run_phase([&] {
    for (const int size : sizes)
      for (const LogGroup& fold : folds)
        for (int s = 0; s < arguments.seeds; ++s) {
          progress.update(static_cast<double>(outcomes.size()) / static_cast<double>(total), "without " + fold.name);
          DraftExperiment seeded = draft;
          seeded.experiment.seed += static_cast<unsigned long long>(s);
          std::vector<std::string> others;
          std::set_difference(files.begin(), files.end(), fold.files.begin(), fold.files.end(),
                              std::back_inserter(others));
          outcomes.push_back(outcome_of(seeded, fold, chosen(others, size, seeded.experiment.seed)));
        }
  });
  progress.finish();
  if (arguments.json) return fmt::print("{}", json_of(outcomes));
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
  command->add_option("EXPERIMENT", arguments->experiment.experiment, "experiment file, or the name of a shipped one")
      ->required();
  command->add_option("--data", arguments->data, "directory of the logs that [log] names: all splits together")
      ->type_name("DIR");
  command
      ->add_option(
          "--group", arguments->group,
          "leave out together the logs in whose names this regular expression finds the same text (else [validation] "
          "groups)")
      ->type_name("REGEX");
  command
      ->add_option("--logs", arguments->sizes,
                   "a learning curve: train on this many of the others; several: a row for each")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("COUNT");
  command->add_option("--seeds", arguments->seeds, "trainings of each, from the experiment's seed on")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command
      ->add_option("--set", arguments->experiment.overrides,
                   "SECTION.KEY=VALUE instead of what the file says; may be repeated")
      ->allow_extra_args(false)
      ->type_name("KEY=VALUE");
  command->add_option("--seed", arguments->experiment.seed, "seed in place of the file's")->check(check_seed);
  command->add_option("--threads", arguments->experiment.threads, "0: all cores; does not change the result");
  command->add_flag("--json", arguments->json, "one JSON array instead of tables: an object for each training");
  command->footer(
      "Nothing is written. The model of a training is chosen by its error on the very logs that it is trained on.\n"
      "Examples:\n"
      "  nlo crossvalidate battery --data logs --group \"^n?[0-9]+degC\" --seeds 3\n"
      "  nlo crossvalidate mine.toml --data logs\n"
      "  nlo crossvalidate mine.toml --data logs --logs 2,4,8");
  command->callback([arguments, &action] { action = [arguments] { run_crossvalidate(*arguments); }; });
}

}  // namespace nlo::trainer
