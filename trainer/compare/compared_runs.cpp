// SPDX-License-Identifier: MIT
#include "trainer/compare/compared_runs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "codegen/base/error.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/filters/plant_equations.h"
#include "trainer/plants/registry.h"
#include "trainer/plants/simulate_runs.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// (truth - estimate)^2 over the channels in their scales, for columns of both.
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

LaneRuns lanes_of(const ComparedRuns& runs, const Experiment& nominal) {
  LaneRuns lanes;
  lanes.sample_period_s = runs.set.sample_period_s;
  lanes.held_inputs = nominal.excitation && nominal.observer.input_hold == Hold::kZeroOrder;
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

/// `count` runs, the first of them number `first_run`. Plants with the same parameters are simulated together, each run
/// with the start and the inputs that it has in the whole set.
Dataset simulated(const Experiment& nominal, const Condition& condition, std::uint64_t engine, int count,
                  std::size_t first_run) {
  const std::size_t turns =
      condition.parameter_factor == 1.0 ? 1 : std::max<std::size_t>(1, nominal.plant->parameters.size());
  Dataset all;
  for (std::size_t turn = 0; turn < turns; ++turn) {
    const Experiment tested = experiment_under(nominal, condition, turn);
    Dataset set = simulate_runs(tested, *make_plant(*tested.plant), engine, count, condition.box_scale);
    if (turn == 0) all = set;
    for (std::size_t i = 0; i < set.trajectories.size(); ++i)
      if ((first_run + i) % turns == turn) all.trajectories[i] = std::move(set.trajectories[i]);
  }
  return all;
}

}  // namespace

Experiment nominal_experiment(const Experiment& experiment) {
  Experiment nominal = experiment;
  nominal.plant->parameter_ranges.clear();
  nominal.simulation.process_noise.clear();
  if (!nominal.plant->model.empty()) nominal.plant->parameters = equations_of(*nominal.plant).parameters;
  return nominal;
}

Experiment experiment_under(const Experiment& nominal, const Condition& condition, std::size_t run) {
  Experiment tested = nominal;
  tested.plant->parameters = changed_parameters(condition, nominal.plant->parameters, run);
  tested.simulation.process_noise = condition.process_noise;
  return tested;
}

ComparedRuns compared_runs(const Experiment& nominal, const Condition& condition, SeedStream stream,
                           std::uint64_t first_seed, int seeds, int count) {
  const auto plant = make_plant(*nominal.plant);
  ComparedRuns runs{{}, {}, {}, PlantChannels(*nominal.plant, *plant), plant->nx(), {}};
  for (int s = 0; s < seeds; ++s) {
    const std::uint64_t seed = first_seed + static_cast<std::uint64_t>(s), engine = initial_state_seed(seed, stream);
    Dataset set =
        simulated(nominal, condition, engine, count, static_cast<std::size_t>(s) * static_cast<std::size_t>(count));
    runs.channels.apply(set);
    const std::uint64_t noise_seed = stream == SeedStream::kTest ? seed : engine;
    for (std::size_t i = 0; i < set.trajectories.size(); ++i) {
      runs.outputs.push_back(
          MeasurementNoise(condition.noise, noise_seed, i).on(set.trajectories[i].outputs, set.output_angles));
      if (s > 0) runs.set.trajectories.push_back(std::move(set.trajectories[i]));
    }
    if (s == 0) runs.set = std::move(set);
  }
  runs.measured = lanes_of(runs, nominal);
  runs.state_scale = share_a_unit(runs.set.states) ? Eigen::VectorXd::Ones(static_cast<Index>(runs.set.states.size()))
                                                   : state_deviation(runs.set);
  return runs;
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
