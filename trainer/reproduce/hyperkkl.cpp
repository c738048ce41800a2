// SPDX-License-Identifier: MIT
// The benchmark of HyperKKL. In each cell, our driven KKL observer is compared with the better of HyperKKL's two
// methods.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/targets/cpp_cost.h"
#include "trainer/base/parallel.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/judge/compare/compared_runs.h"
#include "trainer/judge/compare/table_filter.h"
#include "trainer/judge/evaluation/evaluate.h"
#include "trainer/plants/initial_states.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/simulate.h"
#include "trainer/reproduce/analyses.h"
#include "trainer/reproduce/contest.h"
#include "trainer/reproduce/hyperkkl_cells.h"
#include "trainer/reproduce/smape.h"

namespace nlo::trainer::reproduction {
namespace {

constexpr std::uint64_t kRunsSeed = 1;
constexpr double kNormsFromS = 5.0;  // the error by norms counts samples from this time [s] on
constexpr double kNoiseShare = 0.1;  // standard deviation of the noise / RMS of the output
// Divides the number of test trajectories: 100 runs for each cell; the paper uses 200
constexpr int kRunsShare = 2;
constexpr int kRivalsRuns = 12;
constexpr double kTheirs = 125'000.0;  // multiply-adds for each sample of their observers

/// Simulates a run from `start`. If the plant escapes in finite time (Roessler from x3 near -10: 1 start in 600), draws
/// another start from the whole box.
Dataset bounded_run(const Plant& plant, const SimulationConfig& simulation, Eigen::VectorXd start, const DrivenInput& u,
                    RunRandom& random) {
  constexpr int kTries = 100;
  for (int i = 0;; ++i) {
    try {
      return simulate_from(plant, simulation, start, [u](double t) { return Eigen::VectorXd::Constant(1, u(t)); });
    } catch (const codegen::Error&) {
      if (i == kTries) throw;
      start = latin_hypercube(simulation, 1, random);
    }
  }
}

/// Returns the experiment with the benchmark's box of initial states.
Experiment tested(Experiment experiment, const BenchmarkPlant& plant) {
  SimulationConfig& simulation = experiment.simulation;
  for (std::size_t i = 0; i < simulation.initial_low.size(); ++i) {
    simulation.initial_low[i] = plant.low[i];
    simulation.initial_high[i] = plant.high[i];
  }
  return experiment;
}

/// Simulates new runs of one plant with inputs of one kind. u is continuous in time; the observer reads its samples.
Dataset truth_of(const Experiment& experiment, const InputRange& range, std::uint64_t cell, Eigen::Index runs) {
  const auto plant = make_plant(*experiment.plant);
  RunRandom random(initial_state_seed(kRunsSeed, SeedStream::kTest), RunPurpose::kInputs, 1000 + cell, 0);
  const Eigen::MatrixXd initial = latin_hypercube(experiment.simulation, runs, random);
  Dataset all;
  for (Eigen::Index i = 0; i < runs; ++i) {
    const DrivenInput u = draw_input(range, random);
    Dataset one = bounded_run(*plant, experiment.simulation, initial.col(i), u, random);
    if (i == 0)
      all = std::move(one);
    else
      all.trajectories.push_back(std::move(one.trajectories.front()));
  }
  return all;
}

double output_rms(const Dataset& runs) {
  double squares = 0.0, count = 0.0;
  for (const Trajectory& run : runs.trajectories) {
    squares += run.outputs.squaredNorm();
    count += static_cast<double>(run.outputs.size());
  }
  return std::sqrt(squares / count);
}

/// Returns the error computed in both ways, each as a mean over the runs.
std::pair<double, double> smape_of(const EstimatorFactory& factory, const Dataset& runs, const NoiseConfig& noise,
                                   int threads) {
  const std::size_t count = runs.trajectories.size();
  std::vector<double> components(count), norms(count);
  ThreadPool pool(threads);
  std::vector<Estimator> estimators(static_cast<std::size_t>(pool.threads()));
  pool.run(static_cast<int>(count), [&](int task, int thread) {
    const auto i = static_cast<std::size_t>(task);
    Estimator& estimator = estimators[static_cast<std::size_t>(thread)];
    if (!estimator) estimator = factory();
    const Trajectory& truth = runs.trajectories[i];
    const Eigen::MatrixXd measured = MeasurementNoise(noise, kRunsSeed, i).on(truth.outputs);
    const Eigen::MatrixXd estimate = estimator(measured, truth.inputs, truth.time_s).x_hat;
    components[i] = smape_of_components(truth.states, estimate);
    norms[i] = smape_of_norms(truth.states, estimate, truth.time_s, kNormsFromS);
  });
  return {spread(components).mean, spread(norms).mean};
}

void add(Contender& cell, const std::pair<double, double>& smape) {
  cell.components.push_back(smape.first);
  cell.norms.push_back(smape.second);
}

Contender contender(const Workbench& bench, const BenchmarkPlant& plant, const InputRange& range, const Dataset& runs,
                    const NoiseConfig& noise) {
  Contender cell{plant.title, range.title, {}, {}, {}};
  for (int seed = 0; seed < bench.seeds; ++seed) {
    const codegen::Model& model = bench.model(plant.experiment, seed);
    add(cell, smape_of(observer_estimator(model, has_uniform_steps(runs, model)), runs, noise, bench.threads));
  }
  return cell;
}

/// Estimators without a neural network: an EKF that knows the plant, and a ridge regression. The EKF is tuned and the
/// regression is fitted on training runs.
struct Rivals {
  EstimatorFactory ekf, ridge;
  double multiply_adds = 0.0;  ///< cost of one sample of the EKF
};

Rivals rivals_of(const Experiment& experiment) {
  const ComparedRuns runs = compared_runs(experiment, {}, SeedStream::kTraining, experiment.seed, 1, kRivalsRuns);
  const FilterRow& row = *find_filter("ekf");
  const FilterContext context = filter_context(experiment, {}, {});
  const TunedFilter tuned = tune_filter(row, context, runs);
  return {table_filter("ekf", experiment, {}, false, false, tuned.tuning), baseline_estimator("static_ridge", runs.set),
          row.cost(context, plant_cost(*experiment.plant)).operations / 2.0};
}

}  // namespace

Section hyperkkl(const Workbench& bench) {
  Section section;
  section.contests = {{"inputs as in training", {}},
                      {"the same with output noise of 0.1 of its RMS", {}},
                      {"inputs that training has not seen", {}},
                      {"EKF, tuned: inputs as in training", {}},
                      {"ridge of products, three samples: inputs as in training", {}}};
  Contest &clean = section.contests[0], &noisy = section.contests[1], &far = section.contests[2];
  Contest &ekf = section.contests[3], &ridge = section.contests[4];
  const Eigen::Index runs = std::max(bench.size.test_trajectories / kRunsShare, 1);
  std::string costs, filters;
  std::uint64_t cell = 0;
  for (const BenchmarkPlant& plant : kBenchmarkPlants) {
    const Experiment experiment = tested(bench.experiment(plant.experiment), plant);
    const Rivals rivals = rivals_of(experiment);
    for (std::size_t i = 0; i < kKnownInputs.size(); ++i) {
      const Dataset truth = truth_of(experiment, kKnownInputs[i], cell++, runs);
      clean.cells.push_back(contender(bench, plant, kKnownInputs[i], truth, {}));
      if (plant.published[i] > 0.0) clean.cells.back().published = plant.published[i];
      for (const auto& [contest, factory] : {std::pair{&ekf, &rivals.ekf}, {&ridge, &rivals.ridge}}) {
        contest->cells.push_back({plant.title, kKnownInputs[i].title, clean.cells.back().published, {}, {}});
        add(contest->cells.back(), smape_of(*factory, truth, {}, bench.threads));
      }
      noisy.cells.push_back(
          contender(bench, plant, kKnownInputs[i], truth, {NoiseKind::kGaussian, kNoiseShare * output_rms(truth)}));
    }
    for (const InputRange& range : kFarInputs)
      far.cells.push_back(contender(bench, plant, range, truth_of(experiment, range, cell++, runs), {}));
    costs += fmt::format("{}{} {}", costs.empty() ? "" : ", ", plant.title,
                         codegen::cpp_cost(codegen::PreparedExport(bench.model(plant.experiment, 0))).multiply_adds());
    filters += fmt::format("{}{:.0f}", filters.empty() ? "" : ", ", rivals.multiply_adds);
    bench.progress(static_cast<double>(&plant - kBenchmarkPlants.data() + 1) /
                   static_cast<double>(kBenchmarkPlants.size()));
  }
  section.csv = contests_csv(section.contests);
  section.seen = fmt::format(
      "{}. A cell is ahead if the error of its worst training seed is below the smallest published error. Each cell "
      "has {} runs. The error by components covers the whole run, including its start; the error by norms covers the "
      "time after {:.0f} s. Multiply-adds per sample: {}; HyperKKL {:.0f}; EKF {}.",
      contest_score(clean), runs, kNormsFromS, costs, kTheirs, filters);
  return section;
}

}  // namespace nlo::trainer::reproduction
