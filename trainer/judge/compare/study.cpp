// SPDX-License-Identifier: MIT
#include "trainer/judge/compare/study.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <utility>

#include "codegen/base/error.h"
#include "trainer/base/parallel.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/judge/compare/compared_runs.h"
#include "trainer/judge/compare/entrants.h"
#include "trainer/judge/compare/filter_table.h"
#include "trainer/judge/compare/runs_under.h"
#include "trainer/judge/compare/table_filter.h"
#include "trainer/judge/evaluation/closed_loop.h"
#include "trainer/judge/evaluation/estimator_words.h"
#include "trainer/judge/filters/particle_filter.h"
#include "trainer/plants/drawn_inputs.h"
#include "trainer/plants/excitation.h"
#include "trainer/plants/loop_estimator.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/plant_registry.h"

namespace nlo::trainer {
namespace {

using Eigen::MatrixXd;
using Kind = Entrant::Kind;

// Differs from the seeds of users, so that tuning runs are not test runs.
constexpr std::uint64_t kTuningSeed = 0x74756e65ULL;

/// Returns the parameters that conditions change, in the plant's order.
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

/// Checks the parts of a condition that need the checks of an experiment.
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

bool is_looped(const Experiment& tested, const Condition& condition) {
  return tested.feedback && tested.feedback->share > 0.0 && condition.inputs.empty();
}

/// Data for all conditions of a study.
struct Plan {
  const std::vector<NamedModel>& models;
  const Experiment& trained;
  Experiment known;  ///< the plant that filters know and that conditions change
  const StudyTest& test;
  std::vector<std::string> joint_parameters = {};
  std::vector<Entrant> entrants = {};
  const std::atomic<bool>* stop = nullptr;

  /// Returns the number of threads for one condition. In a study by condition, each thread evaluates whole conditions.
  int threads() const { return test.by_condition ? 1 : test.threads; }
};

/// Test sets that are evaluated together.
struct Batch {
  std::vector<Dataset> sets;               ///< by seed
  std::uint64_t seed = 0;                  ///< seed of the first
  std::size_t first_run = 0;               ///< number of its first run among the runs of all test sets
  std::optional<double> cost = {};         ///< mean_cost() of the loop with the true state
  std::optional<ComparedRuns> lanes = {};  ///< by condition: all runs in the form for filters
};

/// Evaluates one condition. Estimators that do not depend on the test set are made once.
class UnderCondition {
 public:
  UnderCondition(const Plan& plan, const Condition& condition)
      : plan_(plan),
        test_(plan.test),
        condition_(condition),
        tested_(changed_experiment(plan.known, condition.changes)),
        plant_(make_plant(*tested_.plant)),
        config_(metrics_config(tested_, tested_.simulation.horizon_s)) {
    if (test_.by_condition)
      context_ = filter_context(plan.known, condition.noise, plan.joint_parameters);
    else if (tested_.feedback)
      tested_.feedback->error.clear();  // estimators in their own loops are compared with the loop of the true state
    if (test_.tune)
      tuning_ =
          compared_runs(plan.known, condition, SeedStream::kValidation, kTuningSeed, 1, test_.tuning_trajectories);
    for (const Entrant& entrant : plan.entrants) made_.push_back(made(entrant));
  }

  /// Calls `done` after each estimator of each batch.
  StudyRow run(const std::function<void()>& done) {
    StudyRow row;
    for (const NamedModel& model : plan_.models) row.models.push_back(model.name);
    row.cells.resize(plan_.entrants.size());
    for (int first = 0; first < test_.test_sets; first += test_.by_condition ? test_.test_sets : 1) {
      const Batch batch = test_.by_condition ? all_sets() : one_set(first);
      for (std::size_t e = 0; e < row.cells.size(); ++e) {
        if (plan_.stop != nullptr && plan_.stop->load())
          throw codegen::Error("interrupted, so nothing was written; run it again");
        judge(plan_.entrants[e], made_[e], batch, row.cells[e]);
        done();
      }
    }
    return row;
  }

 private:
  /// Returns one factory for each model that the estimator reads; empty if judge() makes the estimator.
  std::vector<EstimatorFactory> made(const Entrant& entrant) {
    if (entrant.kind == Kind::kFilter && !test_.by_condition) return {filter(entrant, condition_.noise)};
    if (entrant.kind != Kind::kSimple) return {};
    if (fresh_.trajectories.empty())
      fresh_ = with_noise(fresh_training_runs(plan_.trained, condition_.input_noise), condition_.noise,
                          fresh_noise_seed(plan_.trained));
    std::vector<EstimatorFactory> factories;
    for (const NamedModel* model : entrant.models)
      factories.push_back(simple_estimator(entrant.made_of, model->model, fresh_, settled_from_s(config_.windows)));
    return factories;
  }

  EstimatorFactory filter(const Entrant& entrant, const NoiseConfig& noise) const {
    const bool beside_one_that_knows_its_errors =
        std::ranges::any_of(plan_.models, [](const NamedModel& m) { return m.model.error.has_value(); });
    return table_filter(entrant.made_of, entrant.knows_changes ? tested_ : plan_.known, noise,
                        holds_inputs(tested_, condition_), beside_one_that_knows_its_errors);
  }

  /// Returns the runs of one seed as channels.
  Dataset runs_of(std::uint64_t seed, std::size_t first_run, const LoopEstimators& estimators,
                  std::optional<double>& cost) const {
    Dataset set = runs_under(tested_, condition_, initial_state_seed(seed, SeedStream::kTest), test_.trajectories,
                             first_run, estimators);
    if (is_looped(tested_, condition_)) cost = mean_cost(tested_, *plant_, set);  // over all states, estimated or not
    PlantChannels(*tested_.plant, *plant_).apply(set);
    return set;
  }

  Batch one_set(int number) const {
    Batch batch;
    batch.seed = test_.seed + static_cast<unsigned>(number);
    batch.first_run = static_cast<std::size_t>(number) * static_cast<std::size_t>(test_.trajectories);
    batch.sets.push_back(runs_of(batch.seed, batch.first_run, {}, batch.cost));
    disturb_inputs(condition_.input_noise, batch.seed, batch.sets.front());
    return batch;
  }

  Batch all_sets() {
    Batch batch;
    batch.seed = test_.seed;
    batch.lanes =
        compared_runs(plan_.known, condition_, SeedStream::kTest, test_.seed, test_.test_sets, test_.trajectories);
    for (int s = 0; s < test_.test_sets; ++s) batch.sets.push_back(set_of(*batch.lanes, s, test_.trajectories));
    if (!share_a_unit(batch.lanes->set.states)) config_.state_scale = batch.lanes->state_scale;
    return batch;
  }

  void judge(const Entrant& entrant, const std::vector<EstimatorFactory>& made, const Batch& batch, StudyCell& cell) {
    if (entrant.kind == Kind::kFilter && test_.by_condition) return side_by_side(entrant, batch, cell);
    if (entrant.kind == Kind::kFloor) return floor_of(entrant, batch, cell);
    cell.evaluations.resize(test_.by_condition ? 1 : plan_.models.size());
    for (std::size_t s = 0; s < batch.sets.size(); ++s)
      for (std::size_t m = 0; m < cell.evaluations.size(); ++m) {
        if (m >= entrant.models.size()) {  // it reads no model: the same for all models
          cell.evaluations[m].push_back(cell.evaluations.front().back());
          continue;
        }
        const Dataset& set = batch.sets[s];
        const codegen::Model& model = entrant.models[m]->model;
        if (entrant.in_loop)
          add(in_own_loop(entrant, model, batch), cell.evaluations[m]);
        else if (entrant.kind == Kind::kObserver)
          add(evaluate_on_plant(model, set, condition_.noise, batch.seed + s, plan_.threads(), config_),
              cell.evaluations[m]);
        else
          add(evaluate(entrant.column.name, made[m], set, condition_.noise, batch.seed + s, plan_.threads(), config_),
              cell.evaluations[m]);
        if (entrant.kind == Kind::kFilter && !entrant.in_loop && !condition_.changes.empty() && !test_.by_condition)
          cell.evaluations[m].back().label =
              fmt::format("{}, {} parameters", entrant.made_of, entrant.knows_changes ? "true" : "nominal");
      }
  }

  void add(Evaluation evaluation, std::vector<Evaluation>& to) const {
    if (test_.by_condition) {  // many cells; their curves and pictures are not shown
      evaluation.examples.clear();
      evaluation.metrics.curve_time_s.resize(0);
      evaluation.metrics.curve.resize(0);
    }
    evaluation.excitation = tested_.excitation && condition_.inputs.empty()
                                ? describe_inputs(*tested_.excitation, *plant_)
                                : name_expressions(*plant_, condition_.inputs);
    if (!condition_.input_noise.none())
      for (std::size_t j = 0; j < evaluation.excitation.size(); ++j)
        evaluation.excitation[j].second += fmt::format(", told with {}", sensor_title(condition_.input_noise.of(j)));
    evaluation.changed = fmt::format("{}", fmt::join(condition_.changes, ", "));
    to.push_back(std::move(evaluation));
  }

  /// Evaluates an estimator in its own loop, with the same starts, references and noise.
  Evaluation in_own_loop(const Entrant& entrant, const codegen::Model& model, const Batch& batch) const {
    const NoiseConfig in_loop = without_shifts(condition_.noise);
    const bool is_observer = entrant.kind == Kind::kObserver;
    const LoopEstimators estimators =
        is_observer ? observer_in_loop(model, tested_, *plant_) : filter_in_loop(entrant.made_of, plan_.known, in_loop);
    std::optional<double> cost;
    const Dataset set = runs_of(batch.seed, batch.first_run, with_noise(estimators, in_loop, batch.seed), cost);
    Evaluation evaluation =
        is_observer ? evaluate_on_plant(model, set, in_loop, batch.seed, plan_.threads(), config_)
                    : evaluate("", filter(entrant, in_loop), set, in_loop, batch.seed, plan_.threads(), config_);
    evaluation.estimator = entrant.column.name;
    evaluation.label = entrant.made_of + " in its own loop";
    evaluation.loop = closed_loop_cost(batch.sets.front(), set);
    evaluation.loop->cost = cost;
    evaluation.loop->of_true_state = batch.cost;
    return evaluation;
  }

  /// Runs a filter on all runs at once, tuned if its column is tuned.
  void side_by_side(const Entrant& entrant, const Batch& batch, StudyCell& cell) const {
    const FilterRow& row = *find_filter(entrant.made_of);
    cell.missing = row.unfit(*context_);
    if (!cell.missing.empty()) return;
    FilterTuning tuning;
    if (entrant.column.is_tuned()) {
      const TunedFilter tuned = tune_filter(row, *context_, *tuning_, plan_.stop);
      tuning = tuned.tuning;
      cell.tuning = tuned.text;
    }
    const auto filter = row.make(*context_, {tuning}, batch.lanes->measured.lanes());
    const std::vector<MatrixXd> x_hat = lane_estimates(*filter, *batch.lanes);
    cell.restarts = filter->restarts();
    by_run(
        entrant, [&](std::size_t run, const MatrixXd&) { return Estimates(x_hat[run]); }, batch, cell);
  }

  void floor_of(const Entrant& entrant, const Batch& batch, StudyCell& cell) const {
    cell.missing = no_likelihood(condition_.noise);
    const ComparedRuns& runs = *batch.lanes;
    if (cell.missing.empty() && runs.plant_states > 3)
      cell.missing = "more than 3 states are too many for the number of particles";
    if (!cell.missing.empty()) return;
    const auto estimate = [&](std::size_t run, const MatrixXd& outputs) {
      const Experiment known = experiment_under(tested_, condition_, run);
      const Trajectory& truth = runs.set.trajectories[run];
      const LaneRuns one =
          one_run(runs.channels.plant_outputs(outputs), truth.inputs, truth.time_s, runs.measured.held_inputs);
      return Estimates(runs.channels.states(particle_estimates(lane_plant(make_plant(*known.plant)), known.simulation,
                                                               condition_.box_scale, condition_.noise, one,
                                                               {test_.particles, test_.seed ^ kTuningSeed}, run)));
    };
    by_run(entrant, estimate, batch, cell);
  }

  /// Evaluates run by run. `estimate` gets the number of the run among those of all test sets.
  void by_run(const Entrant& entrant, const RunEstimator& estimate, const Batch& batch, StudyCell& cell) const {
    cell.evaluations.resize(1);
    std::size_t first = 0;
    for (std::size_t s = 0; s < batch.sets.size(); ++s) {
      const auto of_set = [&]() -> RunEstimator {
        return [&, first](std::size_t run, const MatrixXd& outputs) { return estimate(first + run, outputs); };
      };
      add(evaluate_runs(entrant.column.name, of_set, batch.sets[s], condition_.noise, batch.seed + s, plan_.threads(),
                        config_),
          cell.evaluations.front());
      first += batch.sets[s].trajectories.size();
    }
  }

  const Plan& plan_;
  const StudyTest& test_;
  const Condition& condition_;
  Experiment tested_;
  std::unique_ptr<Plant> plant_;
  MetricsConfig config_;
  Dataset fresh_;                         ///< new runs as in training, for estimators that learn
  std::optional<FilterContext> context_;  ///< set if test_.by_condition
  std::optional<ComparedRuns> tuning_;
  std::vector<std::vector<EstimatorFactory>> made_;  ///< one list for each entrant
};

/// Keeps the run with the largest error of the first observer. The runs of that condition are simulated again.
void keep_worst_run(const Plan& plan, Study& study) {
  WorstRun worst;
  for (std::size_t i = 0; i < study.rows.size(); ++i)
    if (const WorstRun own = worst_run(study.rows[i].observer()); own.norm > worst.norm) {
      worst = own;
      study.worst_row = i;
    }
  const StudyTest& test = study.test;
  const ComparedRuns runs = compared_runs(plan.known, test.conditions[study.worst_row], SeedStream::kTest, test.seed,
                                          test.test_sets, test.trajectories);
  const std::size_t run = worst.set * static_cast<std::size_t>(test.trajectories) + worst.run;
  const Trajectory& truth = runs.set.trajectories[run];
  const codegen::Model& model = plan.models.front().model;
  const Estimator observer = observer_estimator(model, has_uniform_steps(runs.set, model))();
  study.worst.push_back(
      {truth, runs.outputs[run], observer(runs.outputs[run], truth.inputs, truth.time_s).x_hat, "worst"});
}

/// Removes the conditions that cannot be simulated, which have a reason in `impossible`. Throws codegen::Error with the
/// first reason if no condition is left.
void leave_out(const std::vector<std::string>& impossible, Study& study) {
  std::vector<Condition> conditions;
  std::vector<StudyRow> rows;
  for (std::size_t i = 0; i < impossible.size(); ++i) {
    if (!impossible[i].empty()) {
      study.impossible.push_back(impossible[i]);
      continue;
    }
    conditions.push_back(study.test.conditions[i]);
    rows.push_back(std::move(study.rows[i]));
  }
  if (rows.empty() && !impossible.empty())
    throw codegen::Error("the plant cannot be simulated under any condition; " + impossible.front());
  study.test.conditions = std::move(conditions);
  study.rows = std::move(rows);
}

}  // namespace

std::vector<std::string> alternative_names() {
  std::vector<std::string> names = filter_names();
  std::ranges::copy(simple_names(), std::back_inserter(names));
  return names;
}

std::vector<Condition> conditions_of(const std::vector<NoiseConfig>& noises, const Condition& common) {
  std::vector<Condition> result(noises.size(), common);
  for (std::size_t i = 0; i < noises.size(); ++i) result[i].noise = noises[i];
  return result;
}

std::vector<Condition> compared_conditions(const Experiment& experiment, const ConditionSet& set,
                                           std::vector<std::string>& left_out) {
  constexpr int kEnough = 20;
  const Experiment nominal = nominal_experiment(experiment);
  const auto plant = make_plant(*nominal.plant);
  const ComparedRuns clean = compared_runs(nominal, {}, SeedStream::kValidation, nominal.seed, 1, kEnough);
  Dataset own = clean.set;  // noises apply to the plant's own outputs and states
  own.outputs = plant->outputs();
  own.states = plant->outputs();
  for (std::size_t i = 0; i < own.trajectories.size(); ++i) {
    own.trajectories[i].states = clean.channels.plant_outputs(own.trajectories[i].outputs);
  }
  ChannelScales scales;
  scales.outputs = state_deviation(own);
  scales.states = Eigen::VectorXd::Constant(plant->nx(), scales.outputs.mean());
  if (clean.channels.plain()) scales.states = state_deviation(clean.set);
  scales.noise.resize(scales.outputs.size());
  const NoiseConfig trained = experiment.training.all_noise().parts.front();
  for (Eigen::Index j = 0; j < scales.noise.size(); ++j)
    scales.noise[j] = std::sqrt(noise_variance(trained.of(static_cast<std::size_t>(j))));
  std::vector<Condition> conditions = conditions_of(set, nominal.plant->parameters, scales, left_out);
  for (const Condition& condition : conditions) check_changes(condition, nominal, *plant);
  return conditions;
}

Study run_study(const std::vector<NamedModel>& models, const Experiment& experiment, const StudyTest& test,
                const StudyProgress& progress, const std::atomic<bool>* stop) {
  const bool by_condition = test.by_condition;
  Plan plan{models, experiment, by_condition ? nominal_experiment(experiment) : experiment, test};
  plan.stop = stop;
  if (by_condition) {
    plan.joint_parameters = changed_names(test.conditions, plan.known.plant->parameters);
    plan.entrants = compared_entrants(models, plan.known, plan.joint_parameters, test);
  } else if (!test.conditions.empty()) {
    const Condition& first = test.conditions.front();  // all have the same changes and inputs
    plan.entrants = strict_entrants(models, test, is_looped(changed_experiment(experiment, first.changes), first));
  }
  Study study{experiment.name, make_plant(*plan.known.plant)->name(), test, plan.known.simulation.horizon_s};
  for (const Entrant& entrant : plan.entrants) study.estimators.push_back(entrant.column);
  study.rows.resize(test.conditions.size());
  const double all =
      static_cast<double>(study.rows.size() * plan.entrants.size()) * (by_condition ? 1 : test.test_sets);
  double done = 0.0;
  std::mutex mutex;
  std::vector<std::string> impossible(study.rows.size());  // reason for each condition; empty: possible
  ThreadPool pool(by_condition ? test.threads : 1);
  pool.run(static_cast<int>(study.rows.size()), [&](int index, int) {
    const auto row = static_cast<std::size_t>(index);
    const Condition& condition = test.conditions[row];
    try {
      study.rows[row] = UnderCondition(plan, condition).run([&] {
        const std::lock_guard lock(mutex);
        if (progress) progress((done += 1.0) / all, by_condition ? condition.name : "test sets");
      });
    } catch (const codegen::Error& error) {
      if (!test.leave_out_impossible || (stop != nullptr && stop->load())) throw;
      impossible[row] = fmt::format("{}: {}", condition.name, error.what());
    }
  });
  leave_out(impossible, study);
  if (by_condition) keep_worst_run(plan, study);
  return study;
}

}  // namespace nlo::trainer
