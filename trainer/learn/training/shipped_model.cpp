// SPDX-License-Identifier: MIT
#include "trainer/learn/training/shipped_model.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
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
#include "trainer/structures/trainable_structure.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Choice of the features that each state reads.

/// One number for a value that each set of data has.
using Together = std::function<double(const std::function<double(const StateSquares&)>&)>;

/// Takes the worse of training and validation data: validation logs alone may be easier than the training logs, and
/// then a row wins there that loses on harder logs.
Together worst_of(const std::vector<const StateSquares*>& sets) {
  return [sets](const auto& value) {
    double worst = 0.0;
    for (const StateSquares* set : sets) worst = std::max(worst, value(*set));
    return worst;
  };
}

/// Takes the geometric mean over groups that were left out: one log that is unlike all others counts as one. An error
/// below 0.1 % of the state's deviation counts as 0.1 %.
Together typical_of(const std::vector<const StateSquares*>& sets) {
  return [sets](const auto& value) {
    double sum = 0.0;
    for (const StateSquares* set : sets) sum += std::log(std::max(value(*set), 1e-6 * set->deviation + 1e-300));
    return std::exp(sum / static_cast<double>(sets.size()));
  };
}

void find_sensor(const codegen::Model& model, const Together& together, StateReadout& result) {
  std::vector<double> errors;
  for (std::size_t j = 0; j < model.outputs.size(); ++j)
    errors.push_back(std::sqrt(together([j](const StateSquares& s) { return s.reading[j]; })));
  const int best = best_sensor(errors, result.deviation);
  if (best < 0) return;
  result.sensor = errors[static_cast<std::size_t>(best)];
  result.sensor_name = model.outputs[static_cast<std::size_t>(best)].name;
}

struct Choice {
  std::size_t row = 0;                               ///< index among the candidates
  double share = 1.0;                                ///< share of T* beside that row
  double as_map = 0.0, as_row = 0.0, shipped = 0.0;  ///< mean squares of the errors
};

/// Takes the simplest row that is as good as the best, and its best blend with T*. Of row, T* and blend it chooses the
/// first that is as good as the best of them.
///   sets          squares of the state on each set of data that chooses; `together` makes one number of them
///   are_left_out  they are groups of logs that trainings have not seen
Choice choose(const std::vector<const StateSquares*>& sets, const Together& together, bool are_left_out) {
  constexpr double kAlike = 1.02;  // ratio of squared errors: below it, both are as good
  const auto of_row = [&](std::size_t c) { return together([c](const StateSquares& s) { return s.row[c]; }); };
  const std::size_t rows = sets.front()->row.size();
  double least = of_row(0);
  for (std::size_t c = 1; c < rows; ++c) least = std::min(least, of_row(c));
  Choice choice;
  while (choice.row + 1 < rows && !(of_row(choice.row) <= kAlike * least)) ++choice.row;

  const auto of_blend = [&](double share) {
    return together([&](const StateSquares& s) { return s.blend(choice.row, share); });
  };
  double share = sets.back()->best_share(choice.row);  // without logs left out: on validation data
  for (int twentieth = 0; are_left_out && twentieth <= 20; ++twentieth)
    if (const double other = twentieth / 20.0; of_blend(other) < of_blend(share)) share = other;
  choice.as_row = of_row(choice.row);
  choice.as_map = of_blend(1.0);
  const double as_blend = of_blend(share), good = kAlike * std::min({choice.as_row, choice.as_map, as_blend});
  choice.share = choice.as_row <= good ? 0.0 : choice.as_map <= good ? 1.0 : share;
  choice.shipped = choice.share == 0.0 ? choice.as_row : choice.share == 1.0 ? choice.as_map : as_blend;
  return choice;
}

/// Chooses for each state, and writes it into the model's T*.
///   flight        training data as flown with the model's parameters: rows are fitted on it
///   validation    whole validation runs, with noise
///   keeps_hidden  T* keeps its hidden layers though no state uses them: the error head reads the last one
///   left_out      left_out_squares() of each group that was left out of a training; these choose. Empty: flight and
///                 validation do
Readout choose_readout(codegen::Model& model, const Rollout& flight, const Rollout& validation, bool keeps_hidden,
                       const std::vector<SetSquares>& left_out) {
  const SampledTruth training = sample_truth(model, flight, kReadoutSamples);
  const SampledTruth judged = sample_truth(model, validation, kReadoutSamples);
  if (training.weights.size() == 0 || judged.weights.size() == 0) return {};
  const RowInputs inputs(model, training);
  const std::vector<RowCandidate> rows = row_candidates(model, inputs, training);
  const SetSquares on_validation = squares_of(model, inputs, rows, judged);
  const std::vector<SetSquares> sets =
      left_out.empty() ? std::vector<SetSquares>{squares_of(model, inputs, rows, training), on_validation} : left_out;
  for (const SetSquares& set : sets)
    if (set.front().row.size() != rows.size())
      throw codegen::Error("left-out logs: trainings without them have other features");

  codegen::Network* map = codegen::inverse_map(model);
  VectorXd shares = VectorXd::Ones(model.nx());
  MatrixXd chosen_rows = MatrixXd::Zero(model.nx(), 1 + inputs.all());
  bool reads_more = false;
  Readout readout;
  for (Index i = 0; i < model.nx(); ++i) {
    const auto state = static_cast<std::size_t>(i);
    std::vector<const StateSquares*> own;
    for (const SetSquares& set : sets) own.push_back(&set[state]);
    const Together together = left_out.empty() ? worst_of(own) : typical_of(own);
    Choice choice = choose(own, together, !left_out.empty());
    if (map == nullptr) {
      choice.share = 1.0;
      choice.shipped = choice.as_map;
    }
    shares(i) = choice.share;
    if (choice.share < 1.0) {
      chosen_rows.row(i) = rows[choice.row].rows.row(i);
      reads_more = reads_more || rows[choice.row].reads_more;
    }

    constexpr std::size_t kConstant = std::size(kRidges);  // see row_candidates()
    StateReadout& told = readout.emplace_back(
        StateReadout{.state = model.states[state].name,
                     .share = choice.share,
                     .trained = std::sqrt(choice.as_map),
                     .linear = map != nullptr ? std::sqrt(choice.as_row) : std::numeric_limits<double>::infinity(),
                     .shipped = std::sqrt(choice.shipped),
                     .validation = std::sqrt(on_validation[state].blend(choice.row, choice.share)),
                     .constant = std::sqrt(together([](const StateSquares& s) { return s.row[kConstant]; })),
                     .deviation = std::sqrt(on_validation[state].deviation)});
    find_sensor(model, together, told);
  }
  if (map != nullptr && (shares.array() < 1.0).any())
    write_readout(*map, inputs, shares, chosen_rows, reads_more, keeps_hidden);
  return readout;
}

double shipped_rmse(const TrainingEnd& training, const Readout& readout) {
  if (std::all_of(readout.begin(), readout.end(), [](const StateReadout& s) { return s.share == 1.0; }))
    return training.state.best_rmse;
  const bool normalised = training.experiment.loss.is_normalised();
  double squares = 0.0;
  for (std::size_t i = 0; i < readout.size(); ++i) {
    const double scale = normalised ? static_cast<double>(training.structure.state_scale[i]) : 1.0;
    squares += readout[i].validation * readout[i].validation / (scale * scale);
  }
  return std::sqrt(squares);
}

/// Errors of the shipped model on whole runs, before and after `from_s`. A run that ends before has no settled samples.
SplitError split_error(const codegen::Model& model, const Rollout& validation, double from_s) {
  constexpr double kLeast = 1e-3;  // least error, in deviations; a smaller one counts as this
  const SampledTruth judged = sample_truth(model, validation, kReadoutSamples);
  const MatrixXd errors =
      errors_of(codegen::ReferenceObserver<float>(model).estimates(judged.z, judged.y), judged.x, model.states);
  const VectorXd& all = judged.weights;
  VectorXd settled = all;
  for (Index k = 0; k < all.size(); ++k)
    if (judged.since_start[static_cast<std::size_t>(k)] * model.sample_period_s < from_s) settled(k) = 0.0;
  const auto mean = [](const Eigen::RowVectorXd& values, const VectorXd& weights) {
    return values.dot(weights.transpose()) / std::max(weights.sum(), 1e-300);
  };
  Eigen::RowVectorXd squares = Eigen::RowVectorXd::Zero(errors.cols());  // of all states, each over its variance
  for (Index i = 0; i < errors.rows(); ++i) {
    const Eigen::RowVectorXd truth = judged.x.row(i);
    const double variance = mean((truth.array() - mean(truth, all)).square(), all);
    squares += errors.row(i).cwiseAbs2() / std::max(variance, 1e-300);
  }
  const auto error = [&](const VectorXd& weights) { return std::max(std::sqrt(mean(squares, weights)), kLeast); };
  const VectorXd transient = all - settled;
  const bool has_both = settled.sum() > 0.0 && transient.sum() > 0.0;
  return has_both ? SplitError{error(transient), error(settled)} : SplitError{error(all), error(all)};
}

// Facts.

/// The config comes last, because it is long, so that readers of model.json see the other facts first.
void record_facts(const TrainingEnd& training, ShippedModel& shipped) {
  const KnownFacts& known = training.options.facts;
  auto& facts = shipped.model.provenance;
  const auto add = [&facts](std::string name, const std::string& text) {
    if (!text.empty()) facts.emplace_back(std::move(name), text);
  };
  facts = run_facts(training.experiment, training.dataset, training.data_hash, training.state, shipped.validation_rmse);
  if (selects_readout(training.experiment) && training.structure.module->has_inverse_map())
    facts.emplace_back("readout", readout_fact(shipped.readout, training.options.evidence.size()));
  add(kIgnoredInputsFact, known.ignored_inputs);
  if (shipped.model.nu() > 0) add("input_delay", known.input_delay);
  facts.emplace_back("config", training.experiment.source_text);
  add(std::string(kTrainingLogsFact), known.training_logs);
}

// Error head.

constexpr Eigen::Index kCalibrated = 200000;  // samples of a set

/// Fitted on training runs as flown and on segments as drawn, of any length and noise; calibrated on groups of
/// logs that other trainings have left out, and on whole validation runs unless these are the training's.
codegen::ErrorHead error_head(const codegen::Model& model, const float* parameters, const Rollout& flight,
                              Objective& objective, Objective& validator, const TrainingEnd& training) {
  constexpr Eigen::Index kFitted = 30000;
  constexpr int kDraws = 6;
  ErrorSamples samples = error_samples(model, flight, kFitted);
  for (int draw = 0; draw < kDraws; ++draw)
    samples.append(error_samples(model, objective.roll_out_draw(parameters, -2 - draw), kFitted / kDraws));
  const ErrorSamples validation = error_samples(model, validator.roll_out_runs(parameters), kCalibrated);
  codegen::ErrorHead head = fit_error_head(samples, validation);
  std::vector<ErrorScores> scores;
  for (const LeftOutGroup& group : training.options.evidence) scores.push_back(group.scores);
  const bool seen = training.experiment.log && training.experiment.log->validation_files.empty();
  if (scores.empty() || !seen) scores.push_back(error_scores(head, validation));
  calibrate(head, scores);
  return head;
}

}  // namespace

bool selects_readout(const Experiment& experiment) {
  return experiment.inverse_map.readout == ReadoutChoice::kSelected;
}

ShippedModel shipped_model(const TrainingEnd& training, Objective& objective, Objective& validator, ThreadPool& pool) {
  const auto& [experiment, dataset, options, structure, failures, state, data_hash] = training;
  const float* best = state.best.data();
  const Rollout& flight = objective.roll_out_flight(best);
  ShippedModel shipped;
  shipped.model = to_model(structure, best, experiment, dataset, flight);
  codegen::Model& model = shipped.model;
  const auto for_each_left_out = [&training, &pool, best](const auto& judge_on) {
    for (const Dataset& group : training.options.left_out) {
      const TrainingData data(group, training.failures);
      Objective judge(training.experiment, training.structure, data, pool);
      judge_on(judge.roll_out_runs(best));
    }
  };

  for_each_left_out([&](const Rollout& runs) {
    SetSquares squares = left_out_squares(model, flight, runs);
    if (!squares.empty()) shipped.left_out.push_back({std::move(squares), {}});
  });
  if (selects_readout(experiment)) {
    // The same evidence chooses here and for all logs, so that a training without some of them ships the same readouts.
    std::vector<SetSquares> chooses;
    for (const LeftOutGroup& group : options.evidence.empty() ? shipped.left_out : options.evidence)
      chooses.push_back(group.squares);
    shipped.readout =
        choose_readout(model, flight, validator.roll_out_runs(best), experiment.inverse_map.error, chooses);
  }
  shipped.validation_rmse = shipped_rmse(training, shipped.readout);

  if (options.settled_from_s > 0.0)
    shipped.split = split_error(model, validator.roll_out_runs(best), options.settled_from_s);
  record_facts(training, shipped);

  if (experiment.inverse_map.error) {
    model.error = error_head(model, best, flight, objective, validator, training);
    auto next = shipped.left_out.begin();
    for_each_left_out([&](const Rollout& runs) {
      const ErrorSamples samples = error_samples(model, runs, kCalibrated);
      if (samples.size() > 0) (next++)->scores = error_scores(*model.error, samples);
    });
  }
  return shipped;
}

}  // namespace nlo::trainer
