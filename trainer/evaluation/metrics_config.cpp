// SPDX-License-Identifier: MIT
#include "trainer/evaluation/metrics_config.h"

#include <algorithm>

#include "trainer/data/evaluation_windows.h"
#include "trainer/data/transient.h"
#include "trainer/structures/table.h"

namespace nlo::trainer {

MetricsConfig metrics_config(const Experiment& experiment, double horizon_s) {
  MetricsConfig config;
  // A structure without a D may list eigenvalues to start from; its start is forgotten at no rate of theirs.
  const ObserverConfig& observer = experiment.observer;
  const double rate = structure_of(observer).has_eigenvalues() ? decay_rate(observer) : 0.0;
  config.windows = evaluation_windows(experiment.evaluation, rate, horizon_s);
  config.settling_window_s = settling_window_s(experiment.evaluation, config.windows, horizon_s);
  return config;
}

MetricsConfig metrics_config(const Experiment& experiment, const Dataset& logs) {
  double longest_s = 0.0;
  for (const Trajectory& run : logs.trajectories) longest_s = std::max(longest_s, run.time_s[run.samples() - 1]);
  return metrics_config(experiment, longest_s);
}

}  // namespace nlo::trainer
