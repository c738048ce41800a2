// SPDX-License-Identifier: MIT
#include "trainer/judge/compare/compared_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "codegen/base/error.h"
#include "codegen/structures/structure_module.h"
#include "codegen/targets/cpp_cost.h"
#include "codegen/targets/prepared_export.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/judge/evaluation/estimator_words.h"
#include "trainer/plants/plant_registry.h"

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

namespace {

constexpr std::string_view kParticle = "particle";

using Columns = std::vector<ComparedColumn>;

void add_observers(const std::vector<NamedModel>& models, Columns& columns) {
  for (const NamedModel& model : models) {
    CompareColumn column{models.size() == 1 ? "observer" : model.name,
                         fmt::format("{} observer", codegen::structure_name(model.model)), true};
    const codegen::CppCost cost = codegen::cpp_cost(codegen::PreparedExport(model.model));
    column.operations = 2.0 * static_cast<double>(cost.multiply_adds());
    column.functions = static_cast<double>(cost.step_activations + cost.estimate_activations);
    column.state_bytes = static_cast<double>(cost.observer_bytes);
    column.constant_bytes = static_cast<double>(cost.constant_bytes);
    columns.push_back({column, {&model, nullptr, false}});
  }
}

void add_simple(const std::string& name, const std::vector<NamedModel>& models, Columns& columns) {
  for (const NamedModel& model : models) {
    CompareColumn column{name, std::string(estimator_words(name)->meaning)};
    if (name == "ridge" && models.size() > 1) column.name += " of " + model.name;
    columns.push_back({column, {&model, nullptr, false, name}});
    if (name != "ridge") return;  // the others read no model
  }
}

}  // namespace

std::vector<ComparedColumn> compared_columns(const std::vector<NamedModel>& models, const Experiment& nominal,
                                             const std::vector<std::string>& joint_parameters,
                                             const CompareTest& test) {
  const auto wants = [&](std::string_view name) { return std::ranges::find(test.against, name) != test.against.end(); };
  const FilterContext context = filter_context(nominal, {}, joint_parameters);
  const PlantCost plant = plant_cost(*nominal.plant);
  Columns columns;
  add_observers(models, columns);
  for (const FilterRow& row : filter_table()) {
    if (!wants(row.name)) continue;
    CompareColumn column{std::string(row.name), std::string(estimator_words(row.name)->meaning)};
    const StepCost cost = row.cost(context, plant);
    column.operations = cost.operations;
    column.functions = cost.functions;
    column.state_bytes = 4.0 * static_cast<double>(row.state(context));
    columns.push_back({column, {nullptr, &row, false}});
    if (!test.tune) continue;
    column.name += CompareColumn::kTuned;
    column.meaning += ", tuned for each condition";
    columns.push_back({column, {nullptr, &row, true}});
  }
  for (const std::string& name : simple_names())
    if (wants(name)) add_simple(name, models, columns);
  if (!wants(kParticle)) return columns;
  CompareColumn column{std::string(kParticle),
                       fmt::format("{}, {} particles: the floor", estimator_words(kParticle)->meaning, test.particles)};
  const double count = test.particles, nx = static_cast<double>(context.plant.nx);
  const StepCost each = plant.f * 4.0 + plant.h + StepCost{13.0 * nx + 2.0 * nx + 12.0, 1.0};
  column.operations = count * each.operations;
  column.functions = count * each.functions;
  column.state_bytes = 4.0 * count * (nx + 1.0);
  columns.push_back({column, {}});
  return columns;
}

}  // namespace nlo::trainer
