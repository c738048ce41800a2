// SPDX-License-Identifier: MIT
#include "trainer/app/commands/search_task.h"

#include <filesystem>
#include <utility>
#include <vector>

#include "codegen/base/error.h"
#include "trainer/data/log_files.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/judge/evaluation/evaluate.h"
#include "trainer/judge/evaluation/metrics.h"
#include "trainer/plants/initial_states.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/simulate_runs.h"

namespace nlo::trainer {

SearchTask search_task(Experiment experiment, const std::string& data_directory) {
  if (experiment.feedback && experiment.feedback->rounds > 0)
    throw codegen::Error(
        "--auto cannot search experiments with rounds of [feedback], because each round is another training; search "
        "with --set feedback.rounds=0, then train the resulting experiment with its rounds");
  SearchTask task;
  if (experiment.plant) {
    task.data = simulated_data(experiment);
    task.experiment = std::move(experiment);
    return task;
  }
  LogConfig& log = *experiment.log;
  SplitFiles files = expand_splits(log, data_directory);
  if (files.validation.empty()) {
    constexpr std::size_t kPart = 4;  // every fourth log
    if (files.train.size() < 2)
      throw codegen::Error(
          "--auto compares candidates on logs that training has not seen, but there is only one log; name another one "
          "as validation_files in [log]");
    std::vector<std::string> kept;
    for (std::size_t i = 0; i < files.train.size(); ++i) {
      const bool held = i % kPart == kPart - 1 || (files.train.size() < kPart && i + 1 == files.train.size());
      (held ? files.validation : kept).push_back(files.train[i]);
    }
    files.train = std::move(kept);
    for (const std::string& file : files.validation)
      task.held_out += (task.held_out.empty() ? "" : ", ") + std::filesystem::path(file).filename().string();
  }
  log.train_files = files.train;
  log.validation_files = files.validation;
  log.test_files.clear();
  experiment.source_text = format_experiment(experiment);
  task.data = logged_data(experiment, "", true);
  task.experiment = std::move(experiment);
  return task;
}

CandidateData::CandidateData(const SearchTask& task, const Experiment& candidate) : task_(task) {
  const auto keeps = [](const Experiment& e) { return e.training.transient == Transient::kKeep; };
  if (keeps(candidate) && keeps(task.experiment)) return;
  own_ = candidate.plant ? simulated_data(candidate) : logged_data(candidate, "", true);
}

SearchJudge::SearchJudge(const Experiment& experiment, const Dataset& validation) : experiment_(experiment) {
  if (experiment.plant) {
    constexpr int kRuns = 100;
    constexpr std::uint64_t kNoTest = 0x6175746fULL;  // differs from usual seeds of tests
    const auto plant = make_plant(*experiment.plant);
    runs_ = simulate_runs(experiment, *plant, initial_state_seed(experiment.seed ^ kNoTest, SeedStream::kTest), kRuns);
    PlantChannels(*experiment.plant, *plant).apply(runs_);
    config_ = metrics_config(experiment, experiment.simulation.horizon_s);
  } else {
    runs_ = validation;
    config_ = metrics_config(experiment, runs_);
  }
  if (experiment.loss.is_normalised() || !share_a_unit(runs_.states)) config_.state_scale = state_deviation(runs_);
}

double SearchJudge::error(const codegen::Model& model) const {
  const NoiseMixture noise = experiment_.training.all_noise();
  double sum = 0.0;
  for (const NoiseConfig& part : noise.parts)
    sum += evaluate_on_plant(model, runs_, part, experiment_.seed, experiment_.threads, config_).metrics.norm;
  return sum / static_cast<double>(noise.parts.size());
}

}  // namespace nlo::trainer
