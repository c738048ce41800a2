// SPDX-License-Identifier: MIT
#include "trainer/judge/compare/compared_runs.h"

#include <cmath>
#include <utility>

#include "trainer/data/measurement_noise.h"
#include "trainer/judge/evaluation/metrics.h"
#include "trainer/plants/plant_registry.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Returns (truth - estimate)^2 over the scaled channels, column by column.
Eigen::ArrayXd squares(const ComparedRuns& runs, const MatrixXd& truth, const MatrixXd& estimate) {
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(truth.cols());
  for (Index i = 0; i < truth.rows(); ++i) {
    Eigen::ArrayXd difference = (truth.row(i) - estimate.row(i)).transpose().array();
    const double wrap = runs.set.states[static_cast<std::size_t>(i)].wrap;
    if (wrap > 0.0) difference = difference.unaryExpr([wrap](double d) { return std::remainder(d, wrap); }).eval();
    sum += (difference / runs.state_scale[i]).square();
  }
  return sum;
}

}  // namespace

LaneRuns lanes_of(const ComparedRuns& runs, bool held_inputs) {
  LaneRuns lanes;
  lanes.sample_period_s = runs.set.sample_period_s;
  lanes.held_inputs = held_inputs;
  const auto count = static_cast<Index>(runs.outputs.size());
  const Index samples = runs.set.trajectories.front().samples();
  std::vector<MatrixXd> own;
  for (const MatrixXd& outputs : runs.outputs) own.push_back(runs.channels.plant_outputs(outputs));
  lanes.outputs.assign(static_cast<std::size_t>(samples), MatrixXd(own.front().rows(), count));
  const Index nu = runs.set.trajectories.front().inputs.rows();
  if (nu > 0) lanes.inputs.assign(static_cast<std::size_t>(samples), MatrixXd(nu, count));
  for (Index k = 0; k < samples; ++k)
    for (Index lane = 0; lane < count; ++lane) {
      lanes.outputs[static_cast<std::size_t>(k)].col(lane) = own[static_cast<std::size_t>(lane)].col(k);
      if (nu > 0)
        lanes.inputs[static_cast<std::size_t>(k)].col(lane) =
            runs.set.trajectories[static_cast<std::size_t>(lane)].inputs.col(k);
    }
  return lanes;
}

ComparedRuns compared_runs(const Experiment& nominal, const Condition& condition, SeedStream stream,
                           std::uint64_t first_seed, int seeds, int count) {
  const Experiment tested = changed_experiment(nominal, condition.changes);
  const auto plant = make_plant(*tested.plant);
  ComparedRuns runs{{}, {}, {}, PlantChannels(*tested.plant, *plant), plant->nx(), {}};
  for (int s = 0; s < seeds; ++s) {
    const std::uint64_t seed = first_seed + static_cast<std::uint64_t>(s), engine = initial_state_seed(seed, stream);
    Dataset set =
        runs_under(tested, condition, engine, count, static_cast<std::size_t>(s) * static_cast<std::size_t>(count));
    runs.channels.apply(set);
    const std::uint64_t noise_seed = stream == SeedStream::kTest ? seed : engine;
    disturb_inputs(condition.input_noise, noise_seed, set);
    for (std::size_t i = 0; i < set.trajectories.size(); ++i) {
      runs.outputs.push_back(
          MeasurementNoise(condition.noise, noise_seed, i).on(set.trajectories[i].outputs, set.output_angles));
      if (s > 0) runs.set.trajectories.push_back(std::move(set.trajectories[i]));
    }
    if (s == 0) runs.set = std::move(set);
  }
  runs.measured = lanes_of(runs, holds_inputs(tested, condition));
  runs.state_scale = share_a_unit(runs.set.states) ? Eigen::VectorXd::Ones(static_cast<Index>(runs.set.states.size()))
                                                   : state_deviation(runs.set);
  return runs;
}

Dataset set_of(const ComparedRuns& runs, int index, int count) {
  Dataset set = runs.set;
  const auto first = runs.set.trajectories.begin() + static_cast<std::ptrdiff_t>(index) * count;
  set.trajectories.assign(first, first + count);
  return set;
}

std::vector<MatrixXd> lane_estimates(LaneFilter& filter, const ComparedRuns& runs) {
  const LaneRuns& lanes = runs.measured;
  std::vector<MatrixXd> all(runs.set.trajectories.size(),
                            MatrixXd(static_cast<Index>(runs.set.states.size()), lanes.samples()));
  for (Index k = 0; k < lanes.samples(); ++k) {
    const MatrixXd x_hat = runs.channels.states(filter.step(lanes, k).topRows(runs.plant_states));
    for (std::size_t run = 0; run < all.size(); ++run) all[run].col(k) = x_hat.col(static_cast<Index>(run));
  }
  return all;
}

Eigen::ArrayXd squared_errors(LaneFilter& filter, const LaneRuns& lanes, const ComparedRuns& runs) {
  const auto count = static_cast<Index>(runs.set.trajectories.size());
  const auto channels = static_cast<Index>(runs.set.states.size());
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(lanes.lanes());
  MatrixXd truth(channels, count);
  for (Index k = 0; k < lanes.samples(); ++k) {
    for (Index i = 0; i < count; ++i) truth.col(i) = runs.set.trajectories[static_cast<std::size_t>(i)].states.col(k);
    const MatrixXd estimate = runs.channels.states(filter.step(lanes, k).topRows(runs.plant_states));
    sum += squares(runs, truth.replicate(1, lanes.lanes() / count), estimate);
  }
  return sum / static_cast<double>(lanes.samples());
}

double squared_error(const ComparedRuns& runs, std::size_t index, const MatrixXd& estimates, Index first) {
  const Index count = estimates.cols() - first;
  return squares(runs, runs.set.trajectories[index].states.rightCols(count), estimates.rightCols(count)).mean();
}

}  // namespace nlo::trainer
