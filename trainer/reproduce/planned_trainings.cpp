// SPDX-License-Identifier: MIT
#include "trainer/reproduce/planned_trainings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "codegen/base/error.h"
#include "trainer/app/jobs/kept_training.h"
#include "trainer/choose/left_out.h"
#include "trainer/choose/recipe.h"
#include "trainer/data/log_dataset.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/mirrored_channels.h"
#include "trainer/experiments/observer_channels.h"
#include "trainer/experiments/training_sets.h"
#include "trainer/learn/losses/loss_registry.h"
#include "trainer/learn/training/provenance.h"
#include "trainer/learn/training/train.h"
#include "trainer/plants/simulate.h"
#include "trainer/structures/structure_table.h"

namespace nlo::trainer::reproduction {
namespace {

// Measured constants: floating-point operations per second in the forward and backward pass of a network, and seconds
// for the forward and backward pass of the filter over one sample with noise.
constexpr double kFlopsPerSecond = 5e10, kSecondsPerFilteredSample = 4e-9;
constexpr double kSecondsPerStepOnLogs = 0.01;
constexpr double kFlopsPerWeight = 6.0;                          // the forward pass costs 2, the backward pass 4
constexpr double kFlopsPerSecondInSteps = 1e10, kOverhead = 40;  // small networks inside Runge-Kutta stages

/// Returns the number of weights of the hidden layers. The last layer is small.
double weights(double inputs, const std::vector<int>& hidden) {
  double count = 0.0;
  for (const int width : hidden) {
    count += inputs * width;
    inputs = width;
  }
  return count;
}

/// Without validation logs, the training logs select the step, as in nlo train.
TrainingSets logged_sets(const DraftExperiment& draft, const std::string& folder) {
  const Experiment experiment = draft.complete ? draft.experiment : experiment_for_data(draft);
  LogSplits splits = load_log_splits(*experiment.log, folder, mirrored_channels(experiment));
  if (splits.validation.trajectories.empty()) splits.validation = splits.train;
  return {std::move(splits.train), std::move(splits.validation)};
}

/// Returns the experiment with all keys that its draft leaves out.
Experiment completed(const DraftExperiment& draft, const TrainingSets& sets) {
  return draft.complete ? draft.experiment : derive_recipe(draft, sets.training, sets.validation).experiment;
}

}  // namespace

DraftExperiment paper_draft(std::string_view name, const Size& size, int seed) {
  std::vector<std::string> overrides{fmt::format("seed={}", seed)};
  const std::string own_name(name.substr(0, name.find(' ')));
  for (std::size_t at = name.find(' '); at != std::string_view::npos;) {
    const std::size_t next = name.find(' ', at + 1);
    overrides.emplace_back(name.substr(at + 1, next == std::string_view::npos ? next : next - at - 1));
    at = next;
  }
  for (const auto& all : {experiment_texts(), shipped_experiments()})
    for (const ShippedExperiment& shipped : all) {
      if (shipped.name != own_name && shipped.name != "paper/" + own_name) continue;
      const std::string file = std::string(shipped.name) + ".toml";
      DraftExperiment full = parse_draft(shipped.text, file, overrides);
      if (!full.complete && size.steps == kFullSize.steps) return full;
      const int steps = static_cast<int>(std::ceil(full.experiment.training.steps * size.steps));
      overrides.push_back(fmt::format("training.steps={}", steps));
      return parse_draft(shipped.text, file, overrides);
    }
  throw codegen::Error(
      fmt::format("{}: no paper experiment has this name; trainer/experiments/paper/ contains all of them", name));
}

double training_cost_s(const Experiment& experiment) {
  const TrainingConfig& training = experiment.training;
  if (experiment.log) return 1.0 + training.steps * kSecondsPerStepOnLogs;
  const bool all = training.mode == TrainingMode::kFullBatch;
  const int runs = all ? experiment.simulation.trajectories
                       : std::min(training.trajectories_per_step, experiment.simulation.trajectories);
  const double stepped = runs * static_cast<double>(sample_count(experiment.simulation));
  const double evaluated = all ? stepped : training.samples_per_step;
  const auto states = static_cast<double>(experiment.simulation.initial_low.size());
  if (structure_of(experiment.observer).has_dynamics_network())  // RK4 has four sequential stages per sample
    return training.steps * stepped * 4.0 * kFlopsPerWeight *
           (weights(states, experiment.dynamics.hidden) + kOverhead) / kFlopsPerSecondInSteps;
  const auto latent =
      static_cast<double>(experiment.observer.eigenvalues.size() + 2 * experiment.observer.pairs.size());
  double networks = weights(latent, experiment.inverse_map.hidden);
  if (uses_forward_map(experiment)) networks += weights(states, experiment.forward_map.hidden);
  if (needs_equations(experiment.loss))  // each evaluation also computes one tangent per state
    networks += states * weights(states, experiment.forward_map.hidden);
  return training.steps *
         (kFlopsPerWeight * networks * evaluated / kFlopsPerSecond + latent * stepped * kSecondsPerFilteredSample);
}

std::vector<PlannedTraining> plan_trainings(std::span<const Item* const> items, const Size& size, int seeds,
                                            const std::string& data) {
  std::vector<PlannedTraining> jobs;
  for (const Item* item : items) {
    for (const std::string_view name : item->experiments) {
      if (std::any_of(jobs.begin(), jobs.end(), [name](const PlannedTraining& job) { return job.experiment == name; }))
        continue;
      for (int seed = 0; seed < seeds; ++seed) {
        DraftExperiment draft = paper_draft(name, size, seed + 1);
        const double cost_s = training_cost_s(draft.experiment);
        jobs.push_back({std::string(name), seed, std::move(draft), cost_s,
                        item->logs.empty() ? "" : data + "/" + std::string(item->logs)});
      }
    }
  }
  std::stable_sort(jobs.begin(), jobs.end(),
                   [](const PlannedTraining& a, const PlannedTraining& b) { return a.cost_s > b.cost_s; });
  return jobs;
}

JobsResult train_planned(std::span<const PlannedTraining> planned, const std::string& cache, const JobsOptions& options,
                         Models& models) {
  std::vector<codegen::Model> trained(planned.size());
  std::vector<Job> jobs;
  for (std::size_t i = 0; i < planned.size(); ++i) {
    const PlannedTraining& training = planned[i];
    jobs.push_back({fmt::format("{}, seed {}", training.experiment, training.seed + 1), training.cost_s,
                    [&training, &cache, &model = trained[i]](const JobContext& context) {
                      FinishedRun inputs{run_identity(training.draft.experiment)};
                      TrainingSets sets;
                      if (training.draft.experiment.log) {
                        sets = logged_sets(training.draft, training.logs);
                        inputs.data = data_fingerprint(sets.training, fingerprint(nullptr, 0));
                      }
                      const TrainingWork work = [&](const TrainOptions& how) {
                        DraftExperiment draft = training.draft;
                        draft.experiment.threads = context.threads;
                        if (!draft.experiment.log) sets = simulate_training_sets(draft.experiment);
                        const Experiment experiment = completed(draft, sets);
                        return train_with_folds(experiment, sets.training, sets.validation, how);
                      };
                      return load_or_train(kept_folder(cache, inputs), inputs, context, work, model);
                    }});
  }
  JobsResult result = run_jobs(jobs, options);
  result.check();
  for (std::size_t i = 0; i < planned.size(); ++i)
    models.emplace(Workbench::ModelKey{planned[i].experiment, planned[i].seed}, std::move(trained[i]));
  return result;
}

}  // namespace nlo::trainer::reproduction
