// SPDX-License-Identifier: MIT
#include "trainer/app/commands/run_data.h"

#include <fmt/core.h>
#include <fmt/format.h>

#include <utility>

#include "trainer/app/commands/command.h"
#include "trainer/base/printable.h"
#include "trainer/choose/recipe.h"
#include "trainer/data/log_delays.h"
#include "trainer/data/transient.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/mirrored_channels.h"
#include "trainer/experiments/training_sets.h"
#include "trainer/learn/training/provenance.h"
#include "trainer/structures/linear_latent_start.h"

namespace nlo::trainer {

namespace {

/// Returns the experiment without cutting off the transient, whose length depends on eigenvalues that are not known
/// yet.
Experiment with_known_transient(const PreparedRun& run) {
  Experiment experiment = run.experiment;
  if (run.derived) experiment.training.transient = Transient::kKeep;
  return experiment;
}

}  // namespace

RunData simulated_data(const Experiment& experiment) {
  TrainingSets sets = simulate_training_sets(experiment);
  RunData data{std::move(sets.training), std::move(sets.validation)};
  data.warnings = std::move(sets.warnings);
  return data;
}

PreparedRun read_logs(const DraftExperiment& draft, const std::string& directory, bool quiet) {
  PreparedRun run{draft.complete ? draft.experiment : experiment_for_data(draft), {}, !draft.complete};
  if (!run.experiment.log) return run;
  find_delays(run.experiment, directory, quiet);
  run.data = logged_data(with_known_transient(run), directory, quiet);
  return run;
}

std::uint64_t logs_fingerprint(const PreparedRun& run) {
  return run.experiment.log ? training_data_hash(run.data.training, run.data.choosing()) : 0;
}

void simulate_and_derive(const DraftExperiment& draft, const std::string& directory, bool quiet, PreparedRun& run) {
  const auto simulate = [](const Experiment& experiment) {
    return run_phase([&] { return simulated_data(experiment); });
  };
  if (run.experiment.plant) run.data = simulate(with_known_transient(run));
  if (draft.complete) return;
  DraftExperiment found = draft;
  found.experiment.log = run.experiment.log;
  if (!quiet) fmt::print(stderr, "deriving the missing keys of the experiment ...\n");
  Recipe recipe = run_phase([&] { return derive_recipe(found, run.data.training, run.data.choosing()); });
  if (!quiet) fmt::print(stderr, "{}", printable(recipe.text));
  run.experiment = std::move(recipe.experiment);
  if (run.experiment.training.transient == Transient::kKeep) return;
  run.data = {};  // two copies of a log of many rows would be large
  run.data = run.experiment.plant ? simulate(run.experiment) : logged_data(run.experiment, directory, true);
}

void print_warnings(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) fmt::print(stderr, "warning: {}\n", printable(warning));
}

void find_delays(Experiment& experiment, const std::string& directory, bool quiet) {
  const auto found = find_log_delays(*experiment.log, directory, experiment.observer.input_hold);
  if (found.empty()) return;
  experiment.source_text = format_experiment(experiment);
  for (const LogDelay& delay : found)
    if (!quiet) fmt::print(stderr, "{}\n", printable(to_text(delay)));
}

RunData logged_data(const Experiment& experiment, const std::string& directory, bool quiet) {
  LogSplits splits = load_log_splits(*experiment.log, directory, mirrored_channels(experiment));
  if (!quiet) fmt::print(stderr, "{}", printable(to_text(splits.report)));
  check_latent_step(experiment.observer, splits.train.sample_period_s);
  if (splits.validation.trajectories.empty() && !quiet)
    fmt::print(stderr, "no validation_files: the model is selected by its error on the training logs{}\n",
               experiment.inverse_map.error ? ", and its error intervals are too narrow on other logs" : "");
  const bool drops = experiment.training.transient == Transient::kDrop;
  const ReportedLogs reported = logs_to_report_on(splits);
  Dataset judged;  // a log of many rows is large; it is copied only if its transient is dropped
  std::string split = reported.split;
  if (split == "test")
    judged = std::move(splits.test);
  else if (drops)
    judged = reported.logs;
  RunData data{std::move(splits.train), std::move(splits.validation), std::move(judged),
               std::move(split),        std::move(splits.report),     std::move(splits.remembered)};
  if (!drops) return data;
  const double transient_s = transient_time_s(experiment.observer, experiment.training.transient_factor);
  for (Dataset* set : {&data.training, &data.validation}) drop_transient(*set, transient_s);
  return data;
}

}  // namespace nlo::trainer
