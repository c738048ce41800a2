// SPDX-License-Identifier: MIT
#include "trainer/learn/training/shipped_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "trainer/learn/training/provenance.h"
#include "trainer/learn/uncertainty/calibration.h"
#include "trainer/learn/uncertainty/error_head_fit.h"
#include "trainer/structures/module.h"

namespace nlo::trainer {
namespace {

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

constexpr Eigen::Index kCalibrated = 200000;  // samples of a set

/// Fitted on training runs as flown and on segments as drawn, of whatever length and noise; calibrated on groups of
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
  const Rollout& rollout = objective.roll_out_flight(best);
  ShippedModel shipped{to_model(structure, best, experiment, dataset, rollout), {}, {}};
  codegen::Model& model = shipped.model;
  const auto for_each_left_out = [&training, &pool, best](const auto& judge_on) {
    for (const Dataset& group : training.options.left_out) {
      const TrainingData data(group, training.failures);
      Objective judge(training.experiment, training.structure, data, pool);
      judge_on(judge.roll_out_runs(best));
    }
  };
  for_each_left_out([&](const Rollout& runs) {
    SetSquares squares = left_out_squares(model, rollout, runs);
    if (!squares.empty()) shipped.left_out.push_back({std::move(squares), {}});
  });
  const bool selects = selects_readout(experiment);
  if (selects) {
    // What chooses here chooses for all logs, too: so a training without some of them ships what that one will.
    std::vector<SetSquares> chooses;
    for (const LeftOutGroup& group : options.evidence.empty() ? shipped.left_out : options.evidence)
      chooses.push_back(group.squares);
    shipped.readout =
        choose_readout(model, rollout, validator.roll_out_runs(best), experiment.inverse_map.error, chooses);
  }
  shipped.validation_rmse = shipped_rmse(training, shipped.readout);
  note_provenance(experiment, dataset, data_hash, state, shipped.validation_rmse, model);
  if (selects && structure.module->has_inverse_map())
    model.provenance.insert(model.provenance.end() - 1,
                            {"readout", readout_fact(shipped.readout, options.evidence.size())});
  if (experiment.inverse_map.error) {
    model.error = error_head(model, best, rollout, objective, validator, training);
    auto next = shipped.left_out.begin();
    for_each_left_out([&](const Rollout& runs) {
      const ErrorSamples samples = error_samples(model, runs, kCalibrated);
      if (samples.size() > 0) (next++)->scores = error_scores(*model.error, samples);
    });
  }
  return shipped;
}

}  // namespace nlo::trainer
