// SPDX-License-Identifier: MIT
#include "trainer/judge/compare/compare_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <mutex>
#include <set>
#include <utility>

#include "codegen/base/error.h"
#include "trainer/base/parallel.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/judge/compare/compared_runs.h"
#include "trainer/judge/compare/filter_table.h"
#include "trainer/judge/compare/runs_under.h"
#include "trainer/judge/compare/table_filter.h"
#include "trainer/judge/filters/particle_filter.h"
#include "trainer/plants/excitation.h"
#include "trainer/plants/plant_registry.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr std::uint64_t kTuningSeed = 0x74756e65ULL;  // no user's seed: tuning runs are not the test's

/// The parameters that conditions change, in the plant's order.
std::vector<std::string> changed_names(const std::vector<Condition>& conditions,
                                       const std::vector<std::pair<std::string, double>>& nominal) {
  std::set<std::string> changed;
  for (const Condition& condition : conditions)
    for (std::size_t run = 0; run < nominal.size(); ++run) {
      const auto values = changed_parameters(condition, nominal, run);
      for (std::size_t i = 0; i < values.size(); ++i)
        if (values[i].second != nominal[i].second) changed.insert(values[i].first);
    }
  std::vector<std::string> names;
  for (const auto& entry : nominal)
    if (changed.contains(entry.first)) names.push_back(entry.first);
  return names;
}

void set_norms(CompareCell& cell, const Eigen::ArrayXd& squares, int seeds) {
  const Index each = squares.size() / seeds;
  cell.norms.resize(seeds);
  for (Index s = 0; s < seeds; ++s) cell.norms[s] = std::sqrt(squares.segment(s * each, each).mean());
  Index worst = 0;
  cell.worst = std::sqrt(squares.maxCoeff(&worst));
  cell.worst_run = static_cast<std::size_t>(worst);
}

/// What of a condition only the experiment's own checks can judge.
void check_changes(const Condition& condition, const Experiment& nominal, const Plant& plant) {
  try {
    (void)changed_experiment(nominal, condition.changes);
    (void)parse_excitation(plant, condition.inputs);
    check_noise(condition.input_noise, plant.inputs().size());
  } catch (const codegen::Error& error) {
    throw codegen::Error(fmt::format("{}condition \"{}\": {}", condition.place.empty() ? "" : condition.place + ": ",
                                     condition.name, error.what()));
  }
}

class Study {
 public:
  Study(const std::vector<NamedModel>& models, const Experiment& experiment, const ConditionSet& set,
        const CompareTest& test, const StudyProgress& progress, const std::atomic<bool>* stop)
      : models_(models),
        experiment_(experiment),
        nominal_(nominal_experiment(experiment)),
        test_(test),
        progress_(progress),
        stop_(stop) {
    result_.conditions = compared_conditions(experiment, set, result_.left_out);
    result_.experiment = experiment.name;
    result_.plant = make_plant(*nominal_.plant)->name();
    result_.test = test;
    result_.horizon_s = nominal_.simulation.horizon_s;
    joint_parameters_ = changed_names(result_.conditions, nominal_.plant->parameters);
    for (auto& [column, made_of] : compared_columns(models, nominal_, joint_parameters_, test)) {
      result_.columns.push_back(std::move(column));
      made_of_.push_back(std::move(made_of));
    }
  }

  Comparison run() {
    const auto conditions = static_cast<int>(result_.conditions.size());
    result_.cells.assign(result_.conditions.size(), std::vector<CompareCell>(result_.columns.size()));
    all_ = static_cast<double>(conditions) * static_cast<double>(result_.columns.size());
    ThreadPool pool(test_.threads);
    pool.run(conditions, [&](int index, int) { compare_under(static_cast<std::size_t>(index)); });
    keep_worst_run();
    return std::move(result_);
  }

 private:
  void compare_under(std::size_t index) {
    const Condition& condition = result_.conditions[index];
    const ComparedRuns runs =
        compared_runs(nominal_, condition, SeedStream::kTest, test_.seed, test_.seeds, test_.trajectories);
    std::optional<ComparedRuns> tuning;
    if (test_.tune)
      tuning = compared_runs(nominal_, condition, SeedStream::kValidation, kTuningSeed, 1, test_.tuning_trajectories);
    if (index == 0) {
      result_.states = runs.set.states;
      result_.outputs = runs.set.outputs;
      result_.normalised = !share_a_unit(runs.set.states);
    }
    const FilterContext context = filter_context(nominal_, condition.noise, joint_parameters_);
    Dataset fresh;  // for those that learn from runs of the training's own distribution
    for (std::size_t c = 0; c < result_.columns.size(); ++c) {
      if (stop_ != nullptr && stop_->load()) throw codegen::Error("interrupted; nothing was written");
      CompareCell& cell = result_.cells[index][c];
      const MadeOf& made_of = made_of_[c];
      if (!made_of.simple.empty()) {
        if (fresh.trajectories.empty())
          fresh = with_noise(fresh_training_runs(experiment_, condition.input_noise), condition.noise,
                             fresh_noise_seed(experiment_));
        const Estimator simple = simple_estimator(made_of.simple, made_of.model->model, fresh)();
        estimate([&](std::size_t) { return simple; }, runs, cell);
      } else if (made_of.model != nullptr)
        observe(*made_of.model, runs, cell);
      else if (made_of.filter != nullptr)
        filter(*made_of.filter, context, runs, made_of.tuned ? &*tuning : nullptr, cell);
      else
        floor_of(condition, runs, cell);
      report(condition.name);
    }
  }

  /// Run by run. `estimator_of`: a run by its number.
  void estimate(const std::function<Estimator(std::size_t run)>& estimator_of, const ComparedRuns& runs,
                CompareCell& cell) const {
    Eigen::ArrayXd squares(static_cast<Index>(runs.outputs.size()));
    for (std::size_t i = 0; i < runs.outputs.size(); ++i) {
      if (stop_ != nullptr && stop_->load()) return;
      const Trajectory& truth = runs.set.trajectories[i];
      const Estimator estimator = estimator_of(i);
      const MatrixXd x_hat = estimator(runs.outputs[i], truth.inputs, truth.time_s).x_hat;
      squares[static_cast<Index>(i)] = squared_error(runs, i, x_hat);
    }
    set_norms(cell, squares, test_.seeds);
  }

  void observe(const NamedModel& model, const ComparedRuns& runs, CompareCell& cell) const {
    const Estimator observer = observer_estimator(model.model, has_uniform_steps(runs.set, model.model))();
    estimate([&](std::size_t) { return observer; }, runs, cell);
  }

  void filter(const FilterRow& row, const FilterContext& context, const ComparedRuns& runs,
              const ComparedRuns* tuning_runs, CompareCell& cell) const {
    cell.missing = row.unfit(context);
    if (!cell.missing.empty()) return;
    FilterTuning tuning;
    if (tuning_runs != nullptr) {
      const TunedFilter tuned = tune_filter(row, context, *tuning_runs, stop_);
      tuning = tuned.tuning;
      cell.tuning = tuned.text;
    }
    const auto made = row.make(context, {tuning}, runs.measured.lanes());
    const Eigen::ArrayXd squares = squared_errors(*made, runs.measured, runs);
    cell.restarts = made->restarts();
    set_norms(cell, squares, test_.seeds);
  }

  void floor_of(const Condition& condition, const ComparedRuns& runs, CompareCell& cell) const {
    cell.missing = no_likelihood(condition.noise);
    if (cell.missing.empty() && runs.plant_states > 3) cell.missing = "too many states for so few particles";
    if (!cell.missing.empty()) return;
    const bool held = runs.measured.held_inputs;
    const Experiment tested = changed_experiment(nominal_, condition.changes);
    estimate(
        [&](std::size_t run) -> Estimator {
          const Experiment known = experiment_under(tested, condition, run);
          const LanePlant plant = lane_plant(make_plant(*known.plant));
          return [&, known, plant, run, held](const MatrixXd& outputs, const MatrixXd& inputs,
                                              const Eigen::VectorXd& time_s) -> Estimates {
            const LaneRuns one = one_run(runs.channels.plant_outputs(outputs), inputs, time_s, held);
            return runs.channels.states(particle_estimates(plant, known.simulation, condition.box_scale,
                                                           condition.noise, one,
                                                           {test_.particles, test_.seed ^ kTuningSeed}, run));
          };
        },
        runs, cell);
  }

  void report(const std::string& condition) {
    if (!progress_) return;
    const std::lock_guard lock(mutex_);
    done_ += 1.0;
    progress_(done_ / all_, condition);
  }

  /// Of the first observer, where it is furthest off; the runs of that condition are made again.
  void keep_worst_run() {
    std::size_t worst = 0;
    for (std::size_t i = 1; i < result_.cells.size(); ++i)
      if (result_.cells[i].front().worst > result_.cells[worst].front().worst) worst = i;
    const ComparedRuns runs = compared_runs(nominal_, result_.conditions[worst], SeedStream::kTest, test_.seed,
                                            test_.seeds, test_.trajectories);
    const std::size_t run = result_.cells[worst].front().worst_run;
    const Trajectory& truth = runs.set.trajectories[run];
    const Estimator observer =
        observer_estimator(models_.front().model, has_uniform_steps(runs.set, models_.front().model))();
    EvaluatedRun kept{truth, runs.outputs[run], observer(runs.outputs[run], truth.inputs, truth.time_s).x_hat, "worst"};
    result_.worst_condition = worst;
    result_.worst.push_back(std::move(kept));
  }

  const std::vector<NamedModel>& models_;
  const Experiment& experiment_;
  Experiment nominal_;
  const CompareTest& test_;
  const StudyProgress& progress_;
  const std::atomic<bool>* stop_;
  std::vector<std::string> joint_parameters_;
  std::vector<MadeOf> made_of_;
  Comparison result_;
  std::mutex mutex_;
  double done_ = 0.0, all_ = 1.0;
};

}  // namespace

std::vector<Condition> compared_conditions(const Experiment& experiment, const ConditionSet& set,
                                           std::vector<std::string>& left_out) {
  constexpr int kEnough = 20;
  const Experiment nominal = nominal_experiment(experiment);
  const auto plant = make_plant(*nominal.plant);
  const ComparedRuns clean = compared_runs(nominal, {}, SeedStream::kValidation, nominal.seed, 1, kEnough);
  Dataset own = clean.set;  // sensors are of the plant's own outputs; so is process noise of its states
  own.outputs = plant->outputs();
  own.states = plant->outputs();
  for (std::size_t i = 0; i < own.trajectories.size(); ++i) {
    own.trajectories[i].states = clean.channels.plant_outputs(own.trajectories[i].outputs);
  }
  const Eigen::VectorXd outputs = state_deviation(own);
  Eigen::VectorXd states = Eigen::VectorXd::Constant(plant->nx(), outputs.mean());
  if (clean.channels.plain()) states = state_deviation(clean.set);
  std::vector<Condition> conditions = conditions_of(set, nominal.plant->parameters, outputs, states, left_out);
  for (const Condition& condition : conditions) check_changes(condition, nominal, *plant);
  return conditions;
}

Comparison run_comparison(const std::vector<NamedModel>& models, const Experiment& experiment,
                          const ConditionSet& conditions, const CompareTest& test, const StudyProgress& progress,
                          const std::atomic<bool>* stop) {
  return Study(models, experiment, conditions, test, progress, stop).run();
}

}  // namespace nlo::trainer
