// SPDX-License-Identifier: MIT
#include "trainer/app/commands/training_data.h"

#include <fmt/core.h>
#include <fmt/format.h>

#include <utility>

#include "trainer/app/commands/command.h"
#include "trainer/base/printable.h"
#include "trainer/choose/recipe.h"
#include "trainer/data/log_delays.h"
#include "trainer/data/transient.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/mirror.h"
#include "trainer/experiments/training_sets.h"
#include "trainer/structures/linear_latent_start.h"

namespace nlo::trainer {

RunData simulated_data(const Experiment& experiment) {
  TrainingSets sets = simulate_training_sets(experiment);
  return {std::move(sets.training), std::move(sets.validation), {}, {}, {}, std::move(sets.warnings)};
}

PreparedRun prepare_run(const DraftExperiment& draft, const std::string& directory, bool quiet) {
  PreparedRun run{draft.complete ? draft.experiment : experiment_for_data(draft), {}, !draft.complete};
  if (run.experiment.log) find_delays(run.experiment, directory, quiet);
  const auto load = [&](const Experiment& experiment, bool silent) {
    return experiment.plant ? run_phase([&] { return simulated_data(experiment); })
                            : logged_data(experiment, directory, silent);
  };
  if (draft.complete) {
    run.data = load(run.experiment, quiet);
    return run;
  }
  // A transient is as long as the eigenvalues say that are not known yet.
  Experiment whole = run.experiment;
  whole.training.transient = Transient::kKeep;
  run.data = load(whole, quiet);
  DraftExperiment found = draft;
  found.experiment.log = run.experiment.log;
  if (!quiet) fmt::print(stderr, "deriving what the experiment leaves out ...\n");
  Recipe recipe = run_phase([&] { return derive_recipe(found, run.data.training, run.data.validation); });
  if (!quiet) fmt::print(stderr, "{}", printable(recipe.text));
  run.experiment = std::move(recipe.experiment);
  if (run.experiment.training.transient != Transient::kKeep) run.data = load(run.experiment, true);
  return run;
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
  ReportedLogs judged = logs_to_report_on(splits);
  if (splits.validation.trajectories.empty()) {
    if (!quiet)
      fmt::print(stderr, "no validation_files: the model is chosen by its error on the training logs{}\n",
                 experiment.inverse_map.error ? ", and the intervals of its error are too narrow on others" : "");
    splits.validation = splits.train;
  }
  if (experiment.training.transient == Transient::kDrop) {
    const double transient_s = transient_time_s(experiment.observer, experiment.training.transient_factor);
    for (Dataset* split : {&splits.train, &splits.validation}) drop_transient(*split, transient_s);
  }
  return {std::move(splits.train), std::move(splits.validation), std::move(judged), std::move(splits.report),
          std::move(splits.remembered)};
}

}  // namespace nlo::trainer
