// SPDX-License-Identifier: MIT
// nlo crossvalidate: how an observer of logs fares on logs, days and conditions that it was not trained on. Each log, or
// each group of them, is left out once; training sees the others alone.
#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>

#include "trainer/base/printable.h"
#include "trainer/commands/command.h"
#include "trainer/commands/experiment_argument.h"
#include "trainer/commands/patient_progress.h"
#include "trainer/data/log_dataset.h"
#include "trainer/data/log_delays.h"
#include "trainer/data/log_files.h"
#include "trainer/data/log_schema.h"
#include "trainer/data/transient.h"
#include "trainer/evaluation/evaluate_logs.h"
#include "trainer/evaluation/metrics_config.h"
#include "trainer/evaluation/text.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/recipe/recipe.h"
#include "trainer/training/train.h"

namespace nlo::trainer {
namespace {

struct CrossvalidateArguments {
  ExperimentArgument experiment;
  std::string data, group;
  std::vector<int> sizes;
  int seeds = 1;
  bool json = false;
};

/// Files that are left out together.
struct Fold {
  std::string name;
  std::vector<std::string> left_out;
};

/// What one training on `logs` logs gave on a fold.
struct Outcome {
  std::string fold;
  int logs = 0;
  unsigned long long seed = 0;
  std::vector<StateError> observer, ridge, constant;  ///< over all samples of the fold
};

std::string file_name(const std::string& path) {
  return path.substr(path.rfind('/') + 1);
}

std::vector<std::string> all_files(const LogConfig& log, const std::string& directory) {
  const SplitFiles splits = expand_splits(log, directory);
  std::vector<std::string> files = splits.train;
  files.insert(files.end(), splits.validation.begin(), splits.validation.end());
  files.insert(files.end(), splits.test.begin(), splits.test.end());
  std::sort(files.begin(), files.end());
  return files;
}

/// For patterns whose matching takes no more than the product of theirs and the name's size: no references back, and not
/// too many states, which counts multiply: of (a{9}){9} there are 81. Throws std::regex_error.
std::regex bounded_regex(const std::string& pattern) {
  constexpr std::size_t kLongest = 200;
  constexpr double kMostCopies = 1000.0;
  double copies = 1.0;
  for (std::size_t at = pattern.find('{'); at != std::string::npos; at = pattern.find('{', at + 1)) {
    double most = 1.0;
    for (const char* c = pattern.c_str() + at + 1; *c != '\0' && *c != '}';) {
      char* end = nullptr;
      most = std::max(most, std::strtod(c, &end));
      c = end == c ? c + 1 : end;
    }
    copies *= most;
  }
  if (pattern.size() > kLongest || !(copies <= kMostCopies)) throw std::regex_error(std::regex_constants::error_space);
  // Of libstdc++: without it a search may go back and forth for longer than anybody waits, ^(a+)+$ for one.
  return std::regex(pattern, std::regex::ECMAScript | std::regex_constants::__polynomial);
}

/// One fold for each text that `pattern` finds in the files' names (its first group, or all of the match); without a
/// pattern one for each file.
std::vector<Fold> folds_of(const std::vector<std::string>& files, const std::string& pattern) {
  std::map<std::string, std::vector<std::string>> groups;
  try {
    const std::regex regex = bounded_regex(pattern);
    for (const std::string& file : files) {
      const std::string name = file_name(file);
      std::smatch match;
      if (pattern.empty()) {
        groups[name].push_back(file);
      } else if (std::regex_search(name, match, regex)) {
        groups[match[match.size() > 1 ? 1 : 0].str()].push_back(file);
      } else {
        throw codegen::Error(fmt::format(
            "--group {}: finds nothing in \"{}\"; write a pattern that every log's name has", pattern, name));
      }
    }
  } catch (const std::regex_error& error) {
    if (error.code() == std::regex_constants::error_space || error.code() == std::regex_constants::error_complexity)
      throw codegen::Error(fmt::format(
          "--group {}: is too large a pattern, or refers back (\\1); write for example \"^[a-z]+\"", pattern));
    throw codegen::Error(
        fmt::format("--group {}: is not a regular expression; write for example \"^[a-z]+\"", pattern));
  }
  if (groups.size() < 2)
    throw codegen::Error(fmt::format("{} log{} in {} group; crossvalidation needs two groups at least", files.size(),
                                     files.size() == 1 ? "" : "s", groups.size()));
  std::vector<Fold> folds;
  for (auto& [name, members] : groups) folds.push_back({name, std::move(members)});
  return folds;
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

Outcome outcome_of(DraftExperiment draft, const Fold& fold, std::vector<std::string> training) {
  Experiment& experiment = draft.experiment;
  experiment.log->train_files = training;
  experiment.log->validation_files.clear();
  experiment.log->test_files = fold.left_out;
  find_log_delays(*experiment.log, "", experiment.observer.input_hold);  // of these logs alone
  experiment.source_text = format_experiment(experiment);
  LogSplits splits = load_log_splits(*experiment.log, "", experiment.training.mirror);
  if (!draft.complete) experiment = derive_recipe(draft, splits.train, splits.train).experiment;
  if (experiment.training.transient == Transient::kDrop)
    drop_transient(splits.train, transient_time_s(experiment.observer, experiment.training.transient_factor));
  const TrainingResult result = train(experiment, splits.train, splits.train, {});
  if (result.outcome == TrainOutcome::kDiverged) throw codegen::Error(result.message);
  const LogEvaluation evaluation =
      evaluate_on_logs(result.model, splits.test, resolve_columns(*experiment.log), &splits.train, NoiseConfig{},
                       experiment.seed, metrics_config(experiment, splits.test));
  Outcome outcome{fold.name, static_cast<int>(training.size()), experiment.seed, {}, {}, {}};
  for (const LogEvaluation::Entry& entry : evaluation.entries) {
    if (entry.estimator == "observer") outcome.observer = entry.metrics.pooled;
    if (entry.estimator == "ridge") outcome.ridge = entry.metrics.pooled;
    if (entry.estimator == "constant") outcome.constant = entry.metrics.pooled;
  }
  return outcome;
}

struct Spread {
  double mean = 0.0, deviation = 0.0, worst = 0.0;
};

Spread spread_of(const std::vector<double>& values) {
  Spread spread;
  for (const double value : values) {
    spread.mean += value / static_cast<double>(values.size());
    spread.worst = std::max(spread.worst, value);
  }
  for (const double value : values) spread.deviation += (value - spread.mean) * (value - spread.mean);
  spread.deviation = values.size() < 2 ? 0.0 : std::sqrt(spread.deviation / static_cast<double>(values.size() - 1));
  return spread;
}

double rmse(const std::vector<StateError>& errors, std::size_t state) {
  return state < errors.size() ? errors[state].rmse.front() : std::nan("");
}

std::string with_unit(const StateError& state) {
  return state.unit.empty() ? state.name : fmt::format("{} [{}]", state.name, state.unit);
}

/// A row for each fold, the mean over seeds; below it all folds together. `logs`: of the outcomes to show.
std::string fold_table(const std::vector<Outcome>& outcomes, const std::vector<Fold>& folds, int seeds) {
  std::string text;
  const std::vector<StateError>& states = outcomes.front().observer;
  for (std::size_t i = 0; i < states.size(); ++i) {
    TextTable table(
        {"RMSE of " + with_unit(states[i]) + ", left out", "logs", "observer", "over seeds", "ridge", "constant"});
    std::vector<double> all, ridge, constant;
    for (const Fold& fold : folds) {
      std::vector<double> own;
      const Outcome* last = nullptr;
      for (const Outcome& outcome : outcomes)
        if (outcome.fold == fold.name) {
          own.push_back(rmse(outcome.observer, i));
          last = &outcome;
        }
      const Spread spread = spread_of(own);
      all.push_back(spread.mean);
      ridge.push_back(rmse(last->ridge, i));
      constant.push_back(rmse(last->constant, i));
      table.add_row({fold.name, std::to_string(fold.left_out.size()), significant(spread.mean),
                     seeds > 1 ? "+-" + significant(spread.deviation, 2) : "-", significant(ridge.back()),
                     significant(constant.back())});
    }
    table.add_rule();
    const auto row = [&](const std::string& name, double Spread::*what) {
      table.add_row({name, "", significant(spread_of(all).*what), "", significant(spread_of(ridge).*what),
                     significant(spread_of(constant).*what)});
    };
    row("mean", &Spread::mean);
    row("deviation over folds", &Spread::deviation);
    row("worst", &Spread::worst);
    text += (i == 0 ? "" : "\n") + table.to_string(2);
  }
  return text;
}

/// A row for each number of training logs: mean over folds and seeds.
std::string curve_table(const std::vector<Outcome>& outcomes, const std::vector<int>& sizes) {
  std::vector<std::string> headings = {"training logs"};
  for (const StateError& state : outcomes.front().observer) {
    headings.push_back(with_unit(state));
    headings.push_back("ridge");
  }
  TextTable table(std::move(headings));
  for (const int size : sizes) {
    std::vector<std::string> row = {std::to_string(size)};
    for (std::size_t i = 0; i < outcomes.front().observer.size(); ++i) {
      std::vector<double> own, ridge;
      for (const Outcome& outcome : outcomes)
        if (outcome.logs == size) {
          own.push_back(rmse(outcome.observer, i));
          ridge.push_back(rmse(outcome.ridge, i));
        }
      row.push_back(significant(spread_of(own).mean));
      row.push_back(significant(spread_of(ridge).mean));
    }
    table.add_row(std::move(row));
  }
  return table.to_string(2);
}

std::string json_of(const std::vector<Outcome>& outcomes) {
  nlohmann::ordered_json array = nlohmann::ordered_json::array();
  for (const Outcome& outcome : outcomes) {
    nlohmann::ordered_json entry = {
        {"left_out", outcome.fold}, {"training_logs", outcome.logs}, {"seed", outcome.seed}};
    for (std::size_t i = 0; i < outcome.observer.size(); ++i)
      entry["rmse"][outcome.observer[i].name] = {{"observer", rmse(outcome.observer, i)},
                                                 {"ridge", rmse(outcome.ridge, i)},
                                                 {"constant", rmse(outcome.constant, i)}};
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
  const std::vector<Fold> folds = folds_of(files, arguments.group);
  std::size_t fewest = files.size();
  for (const Fold& fold : folds) fewest = std::min(fewest, files.size() - fold.left_out.size());
  for (const int size : arguments.sizes)
    if (size < 1 || static_cast<std::size_t>(size) > fewest)
      throw codegen::Error(fmt::format("--logs {}: between 1 and {} are left to train on", size, fewest));

  const std::vector<int> sizes = arguments.sizes.empty() ? std::vector<int>{0} : arguments.sizes;
  const std::size_t total = sizes.size() * folds.size() * static_cast<std::size_t>(arguments.seeds);
  PatientProgress progress;
  std::vector<Outcome> outcomes;
  run_phase([&] {
    for (const int size : sizes)
      for (const Fold& fold : folds)
        for (int s = 0; s < arguments.seeds; ++s) {
          progress.update(static_cast<double>(outcomes.size()) / static_cast<double>(total), "without " + fold.name);
          DraftExperiment seeded = draft;
          seeded.experiment.seed += static_cast<unsigned long long>(s);
          std::vector<std::string> others;
          std::set_difference(files.begin(), files.end(), fold.left_out.begin(), fold.left_out.end(),
                              std::back_inserter(others));
          outcomes.push_back(outcome_of(seeded, fold, chosen(others, size, seeded.experiment.seed)));
        }
  });
  progress.finish();
  if (arguments.json) return fmt::print("{}", json_of(outcomes));
  fmt::print("{}: {} {} left out one by one, {} training{} each; alternatives fitted on the same training logs\n\n",
             experiment.name, folds.size(), arguments.group.empty() ? "logs" : "groups of logs", arguments.seeds,
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
      ->add_option("--group", arguments->group,
                   "leave out together the logs in whose names this regular expression finds the same text")
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
