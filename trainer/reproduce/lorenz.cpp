// SPDX-License-Identifier: MIT
// The Lorenz system with the test protocol of KalmanNet (Revach et al., IEEE TSP 2022), on new runs.
#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "codegen/targets/cpp_cost.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/data/static_ridge.h"
#include "trainer/judge/compare/compared_runs.h"
#include "trainer/judge/compare/table_filter.h"
#include "trainer/judge/evaluation/evaluate.h"
#include "trainer/plants/initial_states.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/simulate.h"
#include "trainer/reproduce/analyses.h"
#include "trainer/reproduce/exam_table.h"

namespace nlo::trainer::reproduction {
namespace {

constexpr std::uint64_t kFreshSeed = 2022;  // seed of the test runs only
constexpr Eigen::Index kSamples = 3000;
constexpr double kLeadInS = 10.0;  // after this time [s] a run has reached the attractor
// Substeps of the simulation: RK4 is accurate at 0.002 s, while filters and trainings use 0.02 s.
constexpr int kFiner = 10;
constexpr int kFreshShare = 4;   // 50 runs, 150,000 samples
constexpr int kTunedShare = 16;  // 12 runs

/// Returns the experiment with initial states from the whole attractor, as when a filter is switched on during
/// operation.
Experiment anywhere(Experiment experiment) {
  experiment.simulation.initial_low = {-20.0, -25.0, 0.0};
  experiment.simulation.initial_high = {20.0, 25.0, 50.0};
  return experiment;
}

/// Simulates runs of the plant without noise. Test and tuning use different random streams, so they share no initial
/// state.
Dataset attractor_runs(const Experiment& experiment, SeedStream stream, Eigen::Index count) {
  SimulationConfig fine = experiment.simulation;
  const double period_s = fine.sample_period_s;
  fine.sample_period_s /= kFiner;
  fine.horizon_s = kLeadInS + static_cast<double>(kSamples - 1) * period_s;
  const auto plant = make_plant(*experiment.plant);
  Dataset runs = simulate(*plant, fine, initial_state_seed(kFreshSeed, stream), count);
  for (Trajectory& run : runs.trajectories) run = run.from(std::lround(kLeadInS / fine.sample_period_s), kFiner);
  runs.sample_period_s = period_s;
  return runs;
}

/// Returns the runs on which filters are tuned and the ridge regression is fitted.
ComparedRuns tuning_runs(const Experiment& experiment, const NoiseConfig& noise, int count) {
  const auto plant = make_plant(*experiment.plant);
  ComparedRuns runs{attractor_runs(experiment, SeedStream::kTraining, count),
                    {},
                    {},
                    PlantChannels(*experiment.plant, *plant),
                    plant->nx(),
                    Eigen::VectorXd::Ones(plant->nx())};
  const std::uint64_t noise_seed = initial_state_seed(kFreshSeed, SeedStream::kTraining);
  for (std::size_t i = 0; i < runs.set.trajectories.size(); ++i)
    runs.outputs.push_back(MeasurementNoise(noise, noise_seed, i).on(runs.set.trajectories[i].outputs));
  runs.measured = lanes_of(runs, false);
  return runs;
}

class LorenzExam {
 public:
  LorenzExam(const Workbench& bench, const Experiment& experiment)
      : bench_(bench),
        experiment_(anywhere(experiment)),
        noise_(experiment.training.noise),
        fresh_(attractor_runs(experiment_, SeedStream::kTest, std::max(bench.size.test_trajectories / kFreshShare, 1))),
        tuning_(tuning_runs(experiment_, noise_, std::max(bench.size.test_trajectories / kTunedShare, 2))) {}

  ExamRow observer(const std::string& name, const char* experiment) const {
    ExamRow row{name};
    for (int seed = 0; seed < bench_.seeds; ++seed)
      row.values.push_back(
          decibels(evaluate_on_plant(bench_.model(experiment, seed), fresh_, noise_, kFreshSeed, bench_.threads)));
    row.multiply_adds =
        static_cast<double>(codegen::cpp_cost(codegen::PreparedExport(bench_.model(experiment, 0))).multiply_adds());
    return row;
  }

  ExamRow filter(const std::string& name, std::string_view filter) {
    const FilterRow& row = *find_filter(filter);
    const FilterContext context = filter_context(experiment_, noise_, {});
    const TunedFilter tuned = tune_filter(row, context, tuning_);
    tunings_ += fmt::format(" {}: {}.", name, tuned.text);
    return {name,
            {figure(table_filter(filter, experiment_, noise_, false, false, tuned.tuning))},
            {},
            row.cost(context, plant_cost(*experiment_.plant)).operations / 2.0};
  }

  ExamRow ridge(const std::string& name) const {
    Dataset measured = tuning_.set;
    for (std::size_t i = 0; i < measured.trajectories.size(); ++i)
      measured.trajectories[i].outputs = tuning_.outputs[i];
    const auto features = static_cast<double>(StaticRidge::fit(measured).features());
    return {name,
            {figure(baseline_estimator("static_ridge", measured))},
            {},
            features * (0.5 + static_cast<double>(measured.states.size()))};
  }

  ExamRow measurement(const std::string& name) const {
    return {name, {figure([]() -> Estimator {
              return [](const Eigen::MatrixXd& y, const Eigen::MatrixXd&, const Eigen::VectorXd&) { return y; };
            })}};
  }

  std::size_t runs() const { return fresh_.trajectories.size(); }
  std::size_t tuned_on() const { return tuning_.set.trajectories.size(); }
  const std::string& tunings() const { return tunings_; }

 private:
  double figure(const EstimatorFactory& factory) const {
    return decibels(evaluate("", factory, fresh_, noise_, kFreshSeed, bench_.threads));
  }

  /// Returns the mean squared error over runs, samples and components [dB].
  double decibels(const Evaluation& evaluation) const {
    const double norm = evaluation.metrics.norm;
    return 10.0 * std::log10(norm * norm / static_cast<double>(evaluation.states.size()));
  }

  const Workbench& bench_;
  Experiment experiment_;
  NoiseConfig noise_;
  Dataset fresh_;
  ComparedRuns tuning_;
  std::string tunings_;
};

}  // namespace

Section lorenz(const Workbench& bench) {
  LorenzExam exam(bench, bench.experiment("exams/lorenz"));
  Section section;
  section.exams = {{"Lorenz, decimated",
                    "MSE [dB]",
                    {exam.observer("nlo, no equations", "exams/lorenz"),
                     exam.observer("nlo, with equations", "exams/lorenz_equations"), exam.filter("EKF, tuned", "ekf"),
                     exam.filter("UKF, tuned", "ukf"), exam.ridge("ridge of products, three samples"),
                     exam.measurement("the measurement itself"), published("KalmanNet", -11.106),
                     published("RTSNet, a smoother", -16.8), published("EKF, Taylor step", -6.3),
                     published("particle filter", -5.3), published("bidirectional RNN", -2.3)}}};
  section.csv = exams_csv(section.exams);
  section.seen = fmt::format(
      "{} new runs of {} samples. Each run has its own initial state and begins after {:.0f} s, when it is on the "
      "attractor. Filters take one RK4 step per sample and are tuned on {} other runs.{} The published training, "
      "validation and test runs share one noise-free trajectory and differ only in their noise.",
      exam.runs(), kSamples, kLeadInS, exam.tuned_on(), exam.tunings());
  return section;
}

}  // namespace nlo::trainer::reproduction
