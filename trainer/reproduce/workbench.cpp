// SPDX-License-Identifier: MIT
#include "trainer/reproduce/workbench.h"

#include <cmath>

#include "trainer/judge/evaluation/evaluate.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/simulate.h"
#include "trainer/reproduce/paper_noise.h"

namespace nlo::trainer::reproduction {
namespace {

constexpr std::uint64_t kTestSeed = 1;  // seed of the test's initial states and noise, the same for every training seed

/// Returns the error norm over t >= from_s. Every time of a simulation has the same number of samples.
double norm_from(const ErrorMetrics& metrics, double from_s) {
  constexpr double kSlackS = 1e-6;  // 5 s in steps of 0.02 s may be computed as 4.99999 s
  double squares = 0.0;
  Eigen::Index count = 0;
  for (Eigen::Index k = 0; k < metrics.curve.size(); ++k) {
    if (metrics.curve_time_s[k] < from_s - kSlackS) continue;
    squares += metrics.curve[k] * metrics.curve[k];
    ++count;
  }
  return std::sqrt(squares / static_cast<double>(count));
}

}  // namespace

std::vector<NoiseConfig> paper_noises() {
  return {{}, {NoiseKind::kGaussian, 0.5}, {NoiseKind::kUniform, 3.0}};
}

const Experiment& Workbench::experiment(std::string_view name) const {
  return experiments.find(name)->second;
}

const codegen::Model& Workbench::model(std::string_view experiment, int seed) const {
  return models.at({std::string(experiment), seed});
}

Eigen::MatrixXd Workbench::test_states(std::string_view name, double box_scale) const {
  return draw_initial_states(experiment(name).simulation, initial_state_seed(kTestSeed, SeedStream::kTest),
                             size.test_trajectories, box_scale);
}

codegen::Model Workbench::observer(const Trial& trial, int seed) const {
  codegen::Model observer = model(trial.experiment, seed);
  if (!trial.drive) {
    observer = codegen::without_inputs(observer);
    observer.flight = {};  // the flight has inputs, but this observer has none
  }
  return observer;
}

Dataset Workbench::truth(const Trial& trial) const {
  const Experiment& made_by = experiment(trial.experiment);
  const auto plant = make_plant(*made_by.plant);
  return simulate_from(*plant, made_by.simulation, trial.initial, parse_excitation(*plant, trial.inputs));
}

Cell Workbench::measure(const Trial& trial, std::optional<double> paper, double from_s) const {
  const Experiment& made_by = experiment(trial.experiment);
  const Dataset clean = truth(trial);
  Cell cell;
  cell.paper = paper;
  for (int seed = 0; seed < seeds; ++seed) {
    const codegen::Model tried = observer(trial, seed);
    cell.strict.push_back(norm_from(evaluate_on_plant(tried, clean, trial.noise, kTestSeed, threads).metrics, from_s));
    const ErrorMetrics paper_like = evaluate_with_stage_noise(tried, *made_by.plant, made_by.simulation, trial.initial,
                                                              trial.noise, kTestSeed, threads, trial.inputs);
    const double rms = paper_like.nrmse ? paper_like.norm / *paper_like.nrmse : 1.0;  // an RMS of zero cannot divide
    cell.paper_like.push_back(norm_from(paper_like, from_s) / rms);
  }
  return cell;
}

}  // namespace nlo::trainer::reproduction
