// SPDX-License-Identifier: MIT
#include "trainer/learn/training/messages.h"

#include <algorithm>

#include "trainer/base/number_text.h"
#include "trainer/learn/training/parameter_groups.h"

namespace nlo::trainer {

TrainProgress progress_of(const Experiment& experiment, const ObserverStructure& structure, const TrainingState& state,
                          double loss, long first_step, double session_s) {
  TrainProgress progress;
  progress.step = state.step;
  progress.steps = experiment.training.steps;
  progress.loss = loss;
  progress.rmse = state.metrics.back().validation_rmse;
  const std::vector<double> eigenvalues = structure.eigenvalues_at(state.average.data());
  for (const Mode& mode : structure.latent.modes) {
    if (mode.reading < 0 || eigenvalues.empty()) continue;  // a clock, or a structure without D
    const auto row = static_cast<std::size_t>(mode.row);
    progress.eigenvalues.emplace_back(eigenvalues[row], mode.pair ? eigenvalues[row + 1] : 0.0);
  }
  progress.elapsed_s = state.elapsed_s;
  progress.steps_per_s = static_cast<double>(state.step - first_step) / std::max(session_s, 1e-9);
  progress.left_s = static_cast<double>(progress.steps - state.step) / std::max(progress.steps_per_s, 1e-9);
  return progress;
}

std::string divergence_message(const Experiment& experiment, const ObserverStructure& structure, long step,
                               const std::string& what) {
  return "training diverged at step " + std::to_string(step) + ": " + what +
         ". The model of the lowest validation error before that was kept. Try a lower learning_rate (now " +
         shortest_text(experiment.training.learning_rate) + ") or eigenvalue_learning_rate (now " +
         shortest_text(parameter_groups(experiment, structure).front().rate) +
         "), or hold = \"first_order\" if it is \"rk4\".";
}

}  // namespace nlo::trainer
