// SPDX-License-Identifier: MIT
// The trainings that a selection of items needs: each distinct (experiment, seed) once, whoever shares it.
#pragma once

#include <atomic>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/experiments/shipped.h"
#include "trainer/reproduce/cache.h"
#include "trainer/reproduce/registry.h"
#include "trainer/reproduce/run_progress.h"

namespace nlo::trainer::reproduction {

struct Job {
  std::string experiment;  ///< name in trainer/experiments/paper/, or with its folder
  int seed = 0;            ///< index; the experiment's seed is one more
  Experiment config;       ///< with its seed and its share of the steps
  double cost_s = 1.0;     ///< roughly, on one core
};

/// Those that the items train: "paper/..." and "hyperkkl/...".
std::span<const ShippedExperiment> experiment_texts();

/// An experiment of the paper (or "hyperkkl/...") at this size, trained with `seed` (1, 2, ...). Throws codegen::Error for an unknown name.
Experiment paper_experiment(std::string_view name, const Size& size, int seed);

/// Seconds that a training takes, roughly, on one core: its weight in the progress bar.
double training_cost_s(const Experiment& experiment);

/// One job per experiment of the items and seed, the longest first so that the last ones to end are short.
std::vector<Job> plan_jobs(std::span<const Item* const> items, const Size& size, int seeds);

struct Trained {
  std::map<Workbench::ModelKey, codegen::Model> models;
  int trained = 0, cached = 0;
  bool interrupted = false;  ///< some are missing: `stop` was set
};

/// Takes models from the cache and trains the others, one job per thread: a training's bytes do not depend on it.
/// Finished models are cached at once; an interrupted training leaves its checkpoint. `threads` 0: all cores. Throws
/// codegen::Error when a training diverges or a file cannot be written.
Trained train_jobs(std::span<const Job> jobs, const ModelCache& cache, int threads, const std::atomic<bool>* stop,
                   RunProgress& progress);

}  // namespace nlo::trainer::reproduction
