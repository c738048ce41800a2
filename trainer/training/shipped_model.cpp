// SPDX-License-Identifier: MIT
#include "trainer/training/shipped_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "trainer/structures/module.h"
#include "trainer/training/provenance.h"
#include "trainer/uncertainty/calibration.h"
#include "trainer/uncertainty/error_head_fit.h"

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

/// Fitted on training runs as flown and on segments as drawn, of whatever length and noise; calibrated on whole
/// validation runs.
codegen::ErrorHead error_head(const codegen::Model& model, const float* parameters, const Rollout& flight,
                              Objective& objective, Objective& validator) {
  constexpr Eigen::Index kFitted = 30000, kCalibrated = 200000;
  constexpr int kDraws = 6;
  ErrorSamples samples = error_samples(model, flight, kFitted);
  for (int draw = 0; draw < kDraws; ++draw)
    samples.append(error_samples(model, objective.roll_out_draw(parameters, -2 - draw), kFitted / kDraws));
  const ErrorSamples validation = error_samples(model, validator.roll_out_runs(parameters), kCalibrated);
  codegen::ErrorHead head = fit_error_head(samples, validation);
  calibrate(head, validation);
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
  for (const Dataset& group : options.left_out) {
    const TrainingData data(group, failures, experiment.training.mirror);
    Objective judge(experiment, structure, data, pool);
    SetSquares squares = left_out_squares(model, rollout, judge.roll_out_runs(best));
    if (!squares.empty()) shipped.left_out.push_back(std::move(squares));
  }
  const bool selects = selects_readout(experiment);
  if (selects)
    shipped.readout =
        choose_readout(model, rollout, validator.roll_out_runs(best), experiment.inverse_map.error, options.evidence);
  shipped.validation_rmse = shipped_rmse(training, shipped.readout);
  note_provenance(experiment, dataset, data_hash, state, shipped.validation_rmse, model);
  if (selects && structure.module->has_inverse_map())
    model.provenance.insert(model.provenance.end() - 1,
                            {"readout", readout_fact(shipped.readout, options.evidence.size())});
  if (experiment.inverse_map.error) model.error = error_head(model, best, rollout, objective, validator);
  return shipped;
}

}  // namespace nlo::trainer
