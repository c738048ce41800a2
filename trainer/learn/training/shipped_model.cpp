// SPDX-License-Identifier: MIT
#include "trainer/learn/training/shipped_model.h"

#include <algorithm>
#include <cmath>
#include <compare>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "codegen/base/error.h"
#include "codegen/replay/reference_observer.h"
#include "trainer/data/log_baselines.h"
#include "trainer/data/training_logs.h"
#include "trainer/learn/training/provenance.h"
#include "trainer/learn/training/readout_rows.h"
#include "trainer/learn/uncertainty/calibration.h"
#include "trainer/learn/uncertainty/error_head_fit.h"
#include "trainer/rollout/sampled_truth.h"
#include "trainer/structures/structure_table.h"
#include "trainer/structures/trainable_structure.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Choice of the features that each state reads.

/// Squared errors of one state on the data sets that decide. Combines the values of the sets into one number.
class Evidence {
 public:
  using Value = std::function<double(const StateSquares&)>;

  /// `sets` must outlive this object.
  ///   are_left_out  the sets are groups of logs that trainings have not seen; otherwise training and validation data
  Evidence(const std::vector<JudgedSet>& sets, std::size_t state, bool are_left_out)
      : sets_(sets), state_(state), are_left_out_(are_left_out) {}

  std::size_t rows() const { return sets_.front().all[state_].row.size(); }

  /// Returns the value over whole runs, which is reported to users.
  double over_runs(const Value& value) const {
    return together([&](const JudgedSet& set) { return log_mean({&set.all, 1}, value); });
  }

  /// Returns the geometric mean over the transient and the settled samples. The errors of the transient are far larger
  /// and would decide alone.
  double over_windows(const Value& value) const {
    return together([&](const JudgedSet& set) { return log_mean(set.windows, value); });
  }

  /// Returns the value over the settled samples. If a set has no settled samples, all its samples count.
  double settled(const Value& value) const {
    return together([&](const JudgedSet& set) { return log_mean({&set.windows.back(), 1}, value); });
  }

 private:
  using LogOfSet = std::function<double(const JudgedSet&)>;

  /// Returns the mean logarithm of a value over the windows. An error below 0.1 % of the state's deviation counts as
  /// 0.1 %.
  double log_mean(std::span<const SetSquares> windows, const Value& value) const {
    const double least = are_left_out_ || windows.size() > 1 ? 1e-6 : 0.0;
    double sum = 0.0;
    for (const SetSquares& window : windows)
      sum += std::log(std::max(value(window[state_]), least * window[state_].deviation + 1e-300));
    return sum / static_cast<double>(windows.size());
  }

  double together(const LogOfSet& log) const { return are_left_out_ ? typical_of_kinds(log) : worst_of(log); }

  /// Returns the geometric mean over kinds of logs, where each kind has the geometric mean of its groups. So each kind
  /// counts once, independent of its number of logs.
  double typical_of_kinds(const LogOfSet& log) const {
    struct Sum {
      double logs = 0.0, groups = 0.0;
    };
    std::map<std::string_view, Sum> kinds;
    for (const JudgedSet& set : sets_) {
      Sum& sum = kinds[set.kind];
      sum.logs += log(set);
      sum.groups += 1.0;
    }
    double logs = 0.0;
    for (const auto& [kind, sum] : kinds) logs += sum.logs / sum.groups;
    return std::exp(logs / static_cast<double>(kinds.size()));
  }

  /// Returns the larger value of training and validation data. Validation data alone may be easier, so that a row would
  /// win that loses on harder runs.
  double worst_of(const LogOfSet& log) const {
    double worst = -std::numeric_limits<double>::infinity();
    for (const JudgedSet& set : sets_) worst = std::max(worst, log(set));
    return std::exp(worst);
  }

  const std::vector<JudgedSet>& sets_;
  std::size_t state_;
  bool are_left_out_;
};

/// Finds the output that is the best sensor of the state.
///   told_error  returns the RMSE of a value as StateReadout reports it
void find_sensor(const codegen::Model& model, const std::function<double(const Evidence::Value&)>& told_error,
                 StateReadout& result) {
  std::vector<double> errors;
  for (std::size_t j = 0; j < model.outputs.size(); ++j)
    errors.push_back(told_error([j](const StateSquares& s) { return s.reading[j]; }));
  const int best = best_sensor(errors, result.deviation);
  if (best < 0) return;
  result.sensor = errors[static_cast<std::size_t>(best)];
  result.sensor_name = model.outputs[static_cast<std::size_t>(best)].name;
}

/// Cost of a readout; smaller is better.
struct Cost {
  double excess;  ///< mean square over whole runs / largest allowed one; at least 1
  double error;   ///< mean square that decides between allowed readouts
  auto operator<=>(const Cost&) const = default;

  /// Returns true if both are equally good: their mean squares differ by less than 2 %.
  bool is_alike(const Cost& least) const {
    return excess <= kAlike * least.excess && (least.excess > 1.0 || error <= kAlike * least.error);
  }

  /// Returns true if the error is at least 5 % smaller. Smaller gains on left-out logs did not appear on test logs.
  bool is_clearly_below(const Cost& other) const {
    return excess <= kAlike * other.excess && error <= 0.95 * 0.95 * other.error;
  }

  static constexpr double kAlike = 1.02;
};

/// A readout of one state.
struct Choice {
  std::size_t row = 0;                    ///< index among the candidates
  double share = 1.0;                     ///< share of T* beside that row
  std::optional<std::size_t> reach = {};  ///< index in kReaches, if T* falls back to that row

  double squares(const StateSquares& s) const { return reach ? s.fallback[row][*reach] : s.blend(row, share); }
};

/// Judges all readouts of one state. The geometric mean of the transient error and the settled error decides. A readout
/// is allowed if its RMSE over whole runs, which the transient dominates, is at most 5 % above the smallest of T* and
/// the rows.
class Judge {
 public:
  /// `evidence` must outlive this object.
  ///   by_settled  true: only the settled errors decide
  Judge(const Evidence& evidence, bool by_settled) : evidence_(evidence), by_settled_(by_settled) {
    double least = evidence.over_runs([](const StateSquares& s) { return s.map; });
    for (std::size_t c = 0; c < rows(); ++c)
      least = std::min(least, evidence.over_runs([c](const StateSquares& s) { return s.row[c]; }));
    // The same limit as in below_floor(), so that no chosen readout fails there.
    constexpr double kOfWholeRuns = 1.05 * 1.05;
    allowed_over_runs_ = kOfWholeRuns * least + 1e-300;
  }

  std::size_t rows() const { return evidence_.rows(); }

  Cost cost(const Choice& choice) const {
    const auto squares = [&choice](const StateSquares& s) { return choice.squares(s); };
    if (by_settled_) return {1.0, evidence_.settled(squares)};
    return {std::max(evidence_.over_runs(squares) / allowed_over_runs_, 1.0), evidence_.over_windows(squares)};
  }

  /// Returns the first of the choices that is as good as the best of them.
  Choice first_alike(const std::vector<Choice>& choices) const {
    std::vector<Cost> costs;
    for (const Choice& choice : choices) costs.push_back(cost(choice));
    const Cost least = *std::ranges::min_element(costs);
    const auto first = std::ranges::find_if(costs, [&](const Cost& cost) { return cost.is_alike(least); });
    return choices[static_cast<std::size_t>(first - costs.begin())];
  }

 private:
  const Evidence& evidence_;
  bool by_settled_;
  double allowed_over_runs_;
};

/// Selects the simplest row that is as good as the best row, and its best blend with T*. Returns the first of row, T*
/// and blend that is as good as the best of the three. If T* with a fallback to the row is clearly better than all
/// three, returns it with the shortest reach that is as good as the best reach, because that T* follows the row
/// soonest.
Choice choose(const Judge& judge, bool may_fall_back) {
  std::vector<Choice> rows;
  for (std::size_t c = 0; c < judge.rows(); ++c) rows.push_back({.row = c, .share = 0.0});
  const Choice row = judge.first_alike(rows), map{.row = row.row};
  Choice blend = map;
  for (int twentieth = 0; twentieth < 20; ++twentieth)
    if (const Choice other{row.row, twentieth / 20.0}; judge.cost(other) < judge.cost(blend)) blend = other;

  if (may_fall_back) {
    std::vector<Choice> reaches;
    for (std::size_t r = 0; r < kReaches.size(); ++r) reaches.push_back({.row = row.row, .reach = r});
    const Choice fallback = judge.first_alike(reaches);
    if (judge.cost(fallback).is_clearly_below(judge.cost(blend))) return fallback;
  }
  return judge.first_alike({row, map, blend});
}

/// Chooses the readout of each state and writes it into the model's T*.
///   fitted      rows that are fitted to the training data, as flown with the model's parameters
///   validation  whole validation runs, with noise
///   config      if T* has an error head, T* keeps its hidden layers even if no state uses them
///   left_out    squares_on() each group that was left out of a training; these choose. Empty: the training data and
///               the validation runs choose
Readout choose_readout(codegen::Model& model, const FittedRows& fitted, const Rollout& validation,
                       const InverseMapConfig& config, const std::vector<JudgedSet>& left_out) {
  const JudgedSet on_validation = squares_on(model, fitted, validation);
  if (on_validation.all.empty()) return {};
  const RowInputs& inputs = fitted.inputs;
  const std::vector<RowCandidate>& rows = fitted.candidates;
  const bool may_fall_back = codegen::inverse_map(model) != nullptr && config.fallback && !left_out.empty();
  std::vector<JudgedSet> sets = left_out;
  if (sets.empty()) sets = {squares_of(model, fitted, fitted.training), on_validation};
  for (const JudgedSet& set : sets)
    if (set.all.front().row.size() != rows.size())
      throw codegen::Error("left-out logs: trainings without them have other features");
  const auto constant = static_cast<std::size_t>(std::ranges::find_if(rows, &RowCandidate::is_constant) - rows.begin());

  const bool by_settled = config.readout == ReadoutChoice::kSettled;
  codegen::Network* map = codegen::inverse_map(model);
  VectorXd shares = VectorXd::Ones(model.nx()), reach = VectorXd::Zero(model.nx());
  MatrixXd chosen_rows = MatrixXd::Zero(model.nx(), 1 + inputs.all());
  bool reads_more = false;
  Readout readout;
  for (Index i = 0; i < model.nx(); ++i) {
    const auto state = static_cast<std::size_t>(i);
    const Evidence evidence(sets, state, !left_out.empty());
    Choice choice = choose(Judge(evidence, by_settled), may_fall_back);
    if (map == nullptr) choice.share = 1.0;
    shares(i) = choice.share;
    if (choice.reach) reach(i) = kReaches[*choice.reach] * rows[choice.row].distance(i);
    if (choice.share < 1.0 || choice.reach) {
      chosen_rows.row(i) = rows[choice.row].rows.row(i);
      reads_more = reads_more || rows[choice.row].reads_more;
    }

    const auto told_error = [&](const Evidence::Value& value) {
      return std::sqrt(by_settled ? evidence.settled(value) : evidence.over_runs(value));
    };
    const auto error_of = [&](const Choice& other) {
      return told_error([&](const StateSquares& s) { return other.squares(s); });
    };
    StateReadout& told = readout.emplace_back(
        StateReadout{.state = model.states[state].name,
                     .share = choice.share,
                     .reach = reach(i),
                     .trained = error_of({.row = choice.row}),
                     .linear = map != nullptr ? error_of({choice.row, 0.0}) : std::numeric_limits<double>::infinity(),
                     .shipped = error_of(choice),
                     .validation = std::sqrt(choice.squares(on_validation.all[state])),
                     .constant = told_error([&](const StateSquares& s) { return s.row[constant]; }),
                     .deviation = std::sqrt(on_validation.all[state].deviation)});
    find_sensor(model, told_error, told);
  }
  if (map != nullptr && ((shares.array() < 1.0).any() || (reach.array() > 0.0).any()))
    write_readout(*map, inputs, shares, reach, chosen_rows, reads_more, config.error);
  return readout;
}

double shipped_rmse(const TrainingEnd& training, const Readout& readout) {
  if (std::all_of(readout.begin(), readout.end(),
                  [](const StateReadout& s) { return s.share == 1.0 && s.reach == 0.0; }))
    return training.state.best_rmse;
  const bool normalised = training.experiment.loss.is_normalised();
  double squares = 0.0;
  for (std::size_t i = 0; i < readout.size(); ++i) {
    const double scale = normalised ? static_cast<double>(training.structure.state_scale[i]) : 1.0;
    squares += readout[i].validation * readout[i].validation / (scale * scale);
  }
  return std::sqrt(squares);
}

/// Errors of the shipped model on whole runs, see SplitError. A run that ends before has no settled samples.
SplitError split_error(const codegen::Model& model, const Rollout& validation, double settled_from) {
  constexpr double kLeast = 1e-3;  // least error, in deviations; a smaller one counts as this
  const SampledTruth judged = sample_truth(model, validation, kReadoutSamples);
  const MatrixXd errors =
      errors_of(codegen::ReferenceObserver<float>(model).estimates(judged.z, judged.y), judged.x, model.states);
  Eigen::RowVectorXd squares = Eigen::RowVectorXd::Zero(errors.cols());  // sum over the states of error^2 / variance
  for (Index i = 0; i < errors.rows(); ++i)
    squares += errors.row(i).cwiseAbs2() / std::max(weighted_variance(judged.x.row(i), judged.weights), 1e-300);
  const auto error = [&](const VectorXd& weights) {
    return std::max(std::sqrt(weighted_mean(squares, weights)), kLeast);
  };
  const WindowWeights split = split_weights(judged, settled_from);
  if (!split.has_both()) return {error(judged.weights), error(judged.weights)};
  return {error(split.transient), error(split.settled)};
}

// Facts.

/// Adds the facts of the provenance. The experiment's text comes last, because it is long and readers of model.json
/// should see the other facts first.
void record_facts(const TrainingEnd& training, ShippedModel& shipped) {
  const KnownFacts& known = training.options.facts;
  auto& facts = shipped.model.provenance;
  const auto add = [&facts](std::string name, const std::string& text) {
    if (!text.empty()) facts.emplace_back(std::move(name), text);
  };
  facts = run_facts(training.experiment, training.dataset, training.data_hash, training.state, shipped.validation_rmse);
  if (is_chosen(training.experiment.inverse_map.readout) && training.structure.module->has_inverse_map())
    facts.emplace_back("readout", readout_fact(shipped.readout, training.options.evidence.size()));
  add(kIgnoredInputsFact, known.ignored_inputs);
  if (shipped.model.nu() > 0) add("input_delay", known.input_delay);
  facts.emplace_back("config", training.experiment.source_text);
  add(std::string(kTrainingLogsFact), known.training_logs);
}

// Error head.

constexpr Eigen::Index kCalibrated = 200000;  // largest number of samples of a set

/// Returns the error head. It is fitted on training runs as in flight and on segments as drawn in training. It is
/// calibrated on the groups of logs that other trainings have left out, and on whole validation runs unless these are
/// also training runs.
codegen::ErrorHead error_head(const codegen::Model& model, const float* parameters, const Rollout& flight,
                              Objective& objective, const Rollout& whole_runs, const TrainingEnd& training) {
  constexpr Eigen::Index kFitted = 30000;
  constexpr int kDraws = 6;
  ErrorSamples samples = error_samples(model, flight, kFitted);
  for (int draw = 0; draw < kDraws; ++draw)
    samples.append(error_samples(model, objective.roll_out_draw(parameters, -2 - draw), kFitted / kDraws));
  const ErrorSamples validation = error_samples(model, whole_runs, kCalibrated);
  codegen::ErrorHead head = fit_error_head(samples, validation);
  std::vector<ErrorScores> scores;
  for (const LeftOutGroup& group : training.options.evidence) scores.push_back(group.scores);
  const bool seen = training.experiment.log && training.experiment.log->validation_files.empty();
  if (scores.empty() || !seen) scores.push_back(error_scores(head, validation));
  calibrate(head, scores);
  return head;
}

}  // namespace

double settled_from(const Experiment& experiment, const Dataset& dataset, const TrainOptions& options) {
  double from_s = options.settled_from_s;
  if (!(from_s > 0.0)) from_s = settled_from_s(windows_of(experiment, dataset.longest_s()));
  return from_s / dataset.sample_period_s;
}

ShippedModel shipped_model(const TrainingEnd& training, Objective& objective, Objective& validator, ThreadPool& pool) {
  const auto& [experiment, dataset, options, structure, failures, state, data_hash] = training;
  const float* best = state.best.data();
  const Rollout &flight = objective.roll_out_flight(best), &validation = validator.roll_out_runs(best);
  ShippedModel shipped;
  shipped.model = to_model(structure, best, experiment, dataset, flight);
  codegen::Model& model = shipped.model;
  const auto for_each_left_out = [&training, &pool, best](const auto& judge_on) {
    for (const LeftOutLogs& group : training.options.left_out) {
      const TrainingData data(group.logs, training.failures);
      Objective judge(training.experiment, training.structure, data, pool);
      judge_on(judge.roll_out_runs(best), group.kind);
    }
  };

  const double from = settled_from(experiment, dataset, options);
  const bool chooses_readout = is_chosen(experiment.inverse_map.readout);
  std::optional<FittedRows> rows;
  if (chooses_readout || !options.left_out.empty())
    rows = fit_rows(model, flight, from, experiment.inverse_map.fallback);
  for_each_left_out([&](const Rollout& runs, const std::string& kind) {
    JudgedSet squares = rows ? squares_on(model, *rows, runs) : JudgedSet{};
    squares.kind = kind;
    if (!squares.all.empty()) shipped.left_out.push_back({std::move(squares), {}});
  });
  if (chooses_readout && rows) {
    // Errors on left-out logs choose, of this training or of those in `evidence`, so that both ship the same readouts.
    std::vector<JudgedSet> chooses;
    for (const LeftOutGroup& group : options.evidence.empty() ? shipped.left_out : options.evidence)
      chooses.push_back(group.squares);
    shipped.readout = choose_readout(model, *rows, validation, experiment.inverse_map, chooses);
  }
  shipped.validation_rmse = shipped_rmse(training, shipped.readout);

  if (options.settled_from_s > 0.0) shipped.split = split_error(model, validation, from);
  record_facts(training, shipped);

  if (experiment.inverse_map.error) {
    model.error = error_head(model, best, flight, objective, validation, training);
    auto next = shipped.left_out.begin();
    for_each_left_out([&](const Rollout& runs, const std::string&) {
      const ErrorSamples samples = error_samples(model, runs, kCalibrated);
      if (samples.size() > 0) (next++)->scores = error_scores(*model.error, samples);
    });
  }
  return shipped;
}

}  // namespace nlo::trainer
