// SPDX-License-Identifier: MIT
// The trainings for the selected items: each distinct (experiment, seed) once.
#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "trainer/app/jobs/run_jobs.h"
#include "trainer/config/experiment.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/shipped.h"
#include "trainer/reproduce/reproduced_items.h"

namespace nlo::trainer::reproduction {

struct PlannedTraining {
  std::string experiment;  ///< name in trainer/experiments/paper/, or with its folder
  int seed = 0;            ///< index; the experiment's seed is one more
  DraftExperiment draft;   ///< with its seed and its share of the steps; if not complete, a recipe derives the rest
  double cost_s = 1.0;     ///< approximate time on one core
  std::string logs = {};   ///< folder of its logs; empty: it simulates
};

/// Returns the experiments that the items train and nlo does not ship: "paper/...", "hyperkkl/...", "exams/...".
std::span<const ShippedExperiment> experiment_texts();

/// Returns an experiment of the paper (or "hyperkkl/...", or one that nlo ships) at this size, with `seed` (1, 2, ...).
/// If it is not complete, the recipe derives its steps at full size; at smaller sizes it gets a share of the default
/// steps. Throws codegen::Error for an unknown name.
DraftExperiment paper_draft(std::string_view name, const Size& size, int seed);

/// Returns the approximate seconds of a training on one core, which are its weight in the progress bar.
double training_cost_s(const Experiment& experiment);

/// Returns one training for each experiment of the items and each seed, the longest first, so that the last ones to end
/// are short. `data`: the folder that contains the folders of logs.
std::vector<PlannedTraining> plan_trainings(std::span<const Item* const> items, const Size& size, int seeds,
                                            const std::string& data = "");

using Models = std::map<Workbench::ModelKey, codegen::Model>;

/// Trains them, or finds them in the folder `cache` by everything that determines them, including the version of the
/// program.
JobsResult train_planned(std::span<const PlannedTraining> planned, const std::string& cache, const JobsOptions& options,
                         Models& models);

}  // namespace nlo::trainer::reproduction
