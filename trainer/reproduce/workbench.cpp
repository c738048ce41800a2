// SPDX-License-Identifier: MIT
#include "trainer/reproduce/workbench.h"

#include <cmath>

#include "trainer/analysis/evaluate.h"
#include "trainer/analysis/paper_noise.h"
#include "trainer/plants/registry.h"
#include "trainer/plants/simulate.h"

namespace nlo::trainer::reproduction {
namespace {

constexpr std::uint64_t kTestSeed = 1;  // of initial states and noise, whatever seed a model was trained with

/// The error norm over t >= from_s; every instant of a simulation has the same number of samples.
double norm_from(const ErrorMetrics& metrics, double from_s) {
  constexpr double kSlackS = 1e-6;  // 5 s in steps of 0.02 s may read 4.99999
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

Cell Workbench::measure(std::string_view name, const Eigen::MatrixXd& initial, const NoiseConfig& noise,
                        std::optional<double> paper, double from_s) const {
  const Experiment& made_by = experiment(name);
  const Dataset clean = simulate_from(*make_plant(*made_by.plant), made_by.simulation, initial);
  Cell cell;
  cell.paper = paper;
  for (int seed = 0; seed < seeds; ++seed) {
    const codegen::Model& observer = model(name, seed);
    cell.strict.push_back(norm_from(evaluate_on_plant(observer, clean, noise, kTestSeed, threads).metrics, from_s));
    const ErrorMetrics paper_like =
        evaluate_with_stage_noise(observer, *made_by.plant, made_by.simulation, initial, noise, kTestSeed, threads);
    const double rms = paper_like.nrmse ? paper_like.norm / *paper_like.nrmse : 1.0;  // no relative error of a zero state
    cell.paper_like.push_back(norm_from(paper_like, from_s) / rms);
  }
  return cell;
}

}  // namespace nlo::trainer::reproduction
