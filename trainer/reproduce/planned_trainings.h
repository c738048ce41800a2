// SPDX-License-Identifier: MIT
// Plans the trainings for the selected items: each distinct pair (experiment, seed) once.
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
  std::string experiment;  ///< name in trainer/experiments/paper/, or FOLDER/NAME in another folder
  int seed = 0;            ///< index from 0; the seed in the experiment is index + 1
  DraftExperiment draft;   ///< experiment with its seed and steps; a recipe derives the missing keys
  double cost_s = 1.0;     ///< approximate time on one core
  std::string logs = {};   ///< folder of its logs; empty: a simulated experiment
};

/// Returns the experiments that the items train and nlo does not ship: "paper/...", "hyperkkl/...", "exams/...".
std::span<const ShippedExperiment> experiment_texts();

/// Returns an experiment of the paper (or of "hyperkkl/...", or a shipped one) at this size, with `seed` (1, 2, ...).
/// If the experiment is not complete, the recipe derives its steps at full size; at smaller sizes it gets a share of
/// the default steps. Throws codegen::Error for an unknown name.
DraftExperiment paper_draft(std::string_view name, const Size& size, int seed);

/// Returns the approximate time of a training on one core [s], which is its weight in the progress bar.
double training_cost_s(const Experiment& experiment);

/// Returns one training for each experiment of the items and each seed. The longest come first, so that no long
/// training runs alone at the end. `data`: the folder that contains the folders of logs.
std::vector<PlannedTraining> plan_trainings(std::span<const Item* const> items, const Size& size, int seeds,
                                            const std::string& data = "");

using Models = std::map<Workbench::ModelKey, codegen::Model>;

/// Trains the planned models, or finds them in the folder `cache`. The cache key includes everything that determines a
/// model, also the version of the program.
JobsResult train_planned(std::span<const PlannedTraining> planned, const std::string& cache, const JobsOptions& options,
                         Models& models);

}  // namespace nlo::trainer::reproduction
