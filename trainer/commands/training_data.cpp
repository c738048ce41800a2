// SPDX-License-Identifier: MIT
#include "trainer/commands/training_data.h"

#include <fmt/core.h>
#include <fmt/format.h>

#include <utility>

#include "trainer/base/printable.h"
#include "trainer/data/log_delays.h"
#include "trainer/data/transient.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/training_sets.h"
#include "trainer/structures/linear_latent_start.h"

namespace nlo::trainer {

RunData simulated_data(const Experiment& experiment) {
  TrainingSets sets = simulate_training_sets(experiment);
  return {std::move(sets.training), std::move(sets.validation), {}, {}};
}

void find_delays(Experiment& experiment, const std::string& directory, bool quiet) {
  const auto found = find_log_delays(*experiment.log, directory, experiment.observer.input_hold);
  if (found.empty()) return;
  experiment.source_text = format_experiment(experiment);
  for (const LogDelay& delay : found)
    if (!quiet) fmt::print(stderr, "{}\n", printable(to_text(delay)));
}

RunData logged_data(const Experiment& experiment, const std::string& directory, bool quiet) {
  LogSplits splits = load_log_splits(*experiment.log, directory, experiment.training.mirror);
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
