// SPDX-License-Identifier: MIT
#include "trainer/reproduce/jobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <mutex>
#include <optional>
#include <utility>

#include "codegen/base/error.h"
#include "trainer/base/parallel.h"
#include "trainer/experiments/forward_map.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/training_sets.h"
#include "trainer/losses/registry.h"
#include "trainer/plants/simulate.h"
#include "trainer/structures/table.h"
#include "trainer/training/train.h"

namespace nlo::trainer::reproduction {
namespace {

// Measured: floating-point operations of the network's forward and backward pass, and samples of one latent filtered
// forwards and backwards with their noise.
constexpr double kFlopsPerSecond = 5e10, kSecondsPerFilteredSample = 4e-9;
constexpr double kFlopsPerWeight = 6.0;                          // forwards once, backwards twice
constexpr double kFlopsPerSecondInSteps = 1e10, kOverhead = 40;  // small networks inside Runge-Kutta stages

/// Of the hidden layers; the last one is small.
double weights(double inputs, const std::vector<int>& hidden) {
  double count = 0.0;
  for (const int width : hidden) {
    count += inputs * width;
    inputs = width;
  }
  return count;
}

TrainingResult train_job(const Job& job, const std::string& directory, const std::atomic<bool>* stop,
                         const std::function<void(const TrainProgress&)>& progress) {
  Experiment config = job.config;
  config.threads = 1;
  const TrainingSets sets = simulate_training_sets(config);
  TrainOptions options;
  options.directory = directory;
  options.progress = progress;
  options.stop = stop;
  std::error_code ignored;
  options.resume = std::filesystem::exists(directory + "/checkpoint.bin", ignored);
  try {
    return train(config, sets.training, sets.validation, options);
  } catch (const codegen::Error&) {
    if (!options.resume) throw;
    options.resume = false;  // a damaged checkpoint costs its steps, not the run
    return train(config, sets.training, sets.validation, options);
  }
}

}  // namespace

Experiment paper_experiment(std::string_view name, const Size& size, int seed) {
  std::vector<std::string> overrides{fmt::format("seed={}", seed)};
  std::string shipped_name(name.substr(0, name.find(' ')));
  if (shipped_name.find('/') == std::string::npos) shipped_name = "paper/" + shipped_name;
  for (std::size_t at = name.find(' '); at != std::string_view::npos;) {
    const std::size_t next = name.find(' ', at + 1);
    overrides.emplace_back(name.substr(at + 1, next == std::string_view::npos ? next : next - at - 1));
    at = next;
  }
  for (const ShippedExperiment& shipped : experiment_texts()) {
    if (shipped.name != shipped_name) continue;
    const std::string file = shipped_name + ".toml";
    const Experiment full = parse_experiment(shipped.text, file, overrides);
    const int steps = std::max(1, static_cast<int>(std::lround(full.training.steps * size.steps)));
    overrides.push_back(fmt::format("training.steps={}", steps));
    return parse_experiment(shipped.text, file, overrides);
  }
  throw codegen::Error(fmt::format("{}: there is no such experiment of the paper", name));
}

double training_cost_s(const Experiment& experiment) {
  const TrainingConfig& training = experiment.training;
  const bool all = training.mode == TrainingMode::kFullBatch;
  const int runs = all ? experiment.simulation.trajectories
                       : std::min(training.trajectories_per_step, experiment.simulation.trajectories);
  const double stepped = runs * static_cast<double>(sample_count(experiment.simulation));
  const double evaluated = all ? stepped : training.samples_per_step;
  const auto states = static_cast<double>(experiment.simulation.initial_low.size());
  if (structure_of(experiment.observer).has_dynamics_network())  // four stages of RK4 a sample, one after the other
    return training.steps * stepped * 4.0 * kFlopsPerWeight *
           (weights(states, experiment.dynamics.hidden) + kOverhead) / kFlopsPerSecondInSteps;
  const auto latent =
      static_cast<double>(experiment.observer.eigenvalues.size() + 2 * experiment.observer.pairs.size());
  double networks = weights(latent, experiment.inverse_map.hidden);
  if (uses_forward_map(experiment)) networks += weights(states, experiment.forward_map.hidden);
  if (needs_equations(experiment.loss))  // a tangent for each state beside the value
    networks += states * weights(states, experiment.forward_map.hidden);
  return training.steps *
         (kFlopsPerWeight * networks * evaluated / kFlopsPerSecond + latent * stepped * kSecondsPerFilteredSample);
}

std::vector<Job> plan_jobs(std::span<const Item* const> items, const Size& size, int seeds) {
  std::vector<Job> jobs;
  for (const Item* item : items) {
    for (const std::string_view name : item->experiments) {
      if (std::any_of(jobs.begin(), jobs.end(), [name](const Job& job) { return job.experiment == name; })) continue;
      for (int seed = 0; seed < seeds; ++seed) {
        Experiment config = paper_experiment(name, size, seed + 1);
        const double cost_s = training_cost_s(config);
        jobs.push_back({std::string(name), seed, std::move(config), cost_s});
      }
    }
  }
  std::stable_sort(jobs.begin(), jobs.end(), [](const Job& a, const Job& b) { return a.cost_s > b.cost_s; });
  return jobs;
}

Trained train_jobs(std::span<const Job> jobs, const ModelCache& cache, int threads, const std::atomic<bool>* stop,
                   RunProgress& progress) {
  Trained result;
  std::vector<const Job*> open;
  for (const Job& job : jobs) {
    if (auto model = cache.find(job.config)) {
      result.models.emplace(Workbench::ModelKey{job.experiment, job.seed}, std::move(*model));
      ++result.cached;
    } else {
      open.push_back(&job);
      progress.expect(job.cost_s);
    }
  }
  progress.models(static_cast<int>(open.size()));

  std::mutex mutex;
  ThreadPool(threads).run(static_cast<int>(open.size()), [&](int task, int) {
    if (stop != nullptr && stop->load()) return;
    const Job& job = *open[static_cast<std::size_t>(task)];
    const std::string what = fmt::format("training {}, seed {}", job.experiment, job.seed + 1);
    double done = 0.0;
    const TrainingResult training = train_job(job, cache.path(job.config), stop, [&](const TrainProgress& step) {
      const double share = static_cast<double>(step.step) / static_cast<double>(step.steps);
      progress.advance(job.cost_s * (share - done), what);
      done = share;
    });
    if (training.outcome == TrainOutcome::kInterrupted) return;
    if (training.outcome == TrainOutcome::kDiverged)
      throw codegen::Error(fmt::format("{}, seed {}: {}", job.experiment, job.seed + 1, training.message));
    cache.store(job.config, training.model);
    progress.model_done(fmt::format("{}, seed {}", job.experiment, job.seed + 1));
    const std::lock_guard lock(mutex);
    result.models.emplace(Workbench::ModelKey{job.experiment, job.seed}, training.model);
    ++result.trained;
  });
  result.interrupted = result.trained < static_cast<int>(open.size());
  return result;
}

}  // namespace nlo::trainer::reproduction
