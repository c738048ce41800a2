// SPDX-License-Identifier: MIT
// Short trainings on small sets, whole or in parts, and the messages of their errors.
#pragma once

#include <atomic>
#include <string>

#include "tests/support/thrown_message.h"
#include "tests/training/training_testing.h"
#include "trainer/learn/training/train.h"

namespace nlo::trainer {

using testing::harmonics;
using testing::small_experiment;

inline Dataset training_set() {
  return harmonics({40, 60, 33, 50, 28, 60, 44, 35, 60, 40}, false, 1);
}
inline Dataset validation_set() {
  return harmonics({50, 40, 30}, false, 2);
}

inline TrainingResult train_here(const Experiment& experiment, const TrainOptions& options = {}) {
  return train(experiment, training_set(), validation_set(), options);
}

inline TrainOptions writing_to(const ScratchDirectory& directory, bool resume = false) {
  TrainOptions options;
  options.directory = directory.path();
  options.resume = resume;
  return options;
}

/// Stops the run after `steps` of this session.
inline TrainingResult train_for(const Experiment& experiment, const std::string& directory, bool resume, int steps) {
  std::atomic<bool> stop = false;
  TrainOptions options;
  options.directory = directory;
  options.resume = resume;
  options.stop = &stop;
  int done = 0;
  options.progress = [&](const TrainProgress&) { stop = ++done >= steps; };
  return train_here(experiment, options);
}

inline std::string error_of(const Experiment& experiment, const Dataset& training, const Dataset& validation,
                            const TrainOptions& options = {}) {
  return thrown_message([&] { (void)train(experiment, training, validation, options); });
}

}  // namespace nlo::trainer
