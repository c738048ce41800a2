// SPDX-License-Identifier: MIT
#include "trainer/reproduce/workbench.h"

#include "trainer/analysis/evaluate.h"
#include "trainer/analysis/paper_noise.h"
#include "trainer/plants/registry.h"
#include "trainer/plants/simulate.h"

namespace nlo::trainer::reproduction {
namespace {

constexpr std::uint64_t kTestSeed = 1;  // of initial states and noise, whatever seed a model was trained with

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

Cell Workbench::measure(std::string_view name, const Eigen::MatrixXd& initial, const NoiseConfig& noise) const {
  const Experiment& made_by = experiment(name);
  const Dataset clean = simulate_from(*make_plant(*made_by.plant), made_by.simulation, initial);
  Cell cell;
  for (int seed = 0; seed < seeds; ++seed) {
    const codegen::Model& observer = model(name, seed);
    cell.strict.push_back(evaluate_on_plant(observer, clean, noise, kTestSeed, threads).metrics.norm);
    const ErrorMetrics paper_like =
        evaluate_with_stage_noise(observer, *made_by.plant, made_by.simulation, initial, noise, kTestSeed, threads);
    cell.paper_like.push_back(paper_like.nrmse.value_or(paper_like.norm));
  }
  return cell;
}

Cell Workbench::measure(std::string_view name, const Eigen::MatrixXd& initial, const NoiseConfig& noise,
                        double paper) const {
  Cell cell = measure(name, initial, noise);
  cell.paper = paper;
  return cell;
}

}  // namespace nlo::trainer::reproduction
