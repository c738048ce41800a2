// SPDX-License-Identifier: MIT
// Turns flat parameters into a model: names, units, ranges, domain, and networks with their normalisation.
#include <algorithm>
#include <cmath>
#include <limits>

#include "codegen/model/computed_outputs.h"
#include "codegen/model/latent_step.h"
#include "trainer/structures/activation_range.h"
#include "trainer/structures/flight_record.h"
#include "trainer/structures/for_each_sample.h"
#include "trainer/structures/structure.h"
#include "trainer/structures/trainable_structure.h"

namespace nlo::trainer {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Sets the ranges of a model. The domain has the latent states of training, relative to S y for relative outputs, plus
/// a tenth of their range. A reading counts as impossible if it exceeds its range by more than the width of the range,
/// or, if the noise has tails, if it exceeds the limits of the training. Angles have 64 turns here and 2^16 in flight
/// (codegen/model/flown_ranges.h), where relative outputs are not clamped either.
void set_ranges(codegen::Model& model, const Rollout& rollout, const TrainingConfig& training) {
  const MatrixXd steady_gain = codegen::steady_gain(model);
  const Index nz = model.nz(), ny = model.ny(), nr = model.nr();
  model.latent_min = VectorXd::Constant(nz, std::numeric_limits<double>::infinity());
  model.latent_max = -model.latent_min;
  VectorXd low = VectorXd::Constant(nr, std::numeric_limits<double>::infinity()), high = -low;
  VectorXd y(nr);
  for_each_sample(rollout, [&](const Segment&, const SegmentGroup& group, int lane, int time) {
    const auto at = [&](const std::vector<float>& signal, Index row) {
      return static_cast<double>(signal[group.at(static_cast<int>(row), time) + static_cast<std::size_t>(lane)]);
    };
    for (Index j = 0; j < nr; ++j) y(j) = at(group.readings, j);
    low = low.cwiseMin(y);
    high = high.cwiseMax(y);
    for (Index r = 0; r < nz; ++r) {
      double z = at(group.latent, r);
      for (Index j = 0; j < ny; ++j) {
        if (is_relative(model, static_cast<int>(j))) z -= steady_gain(r, j) * y(j);
      }
      model.latent_min(r) = std::min(model.latent_min(r), z);
      model.latent_max(r) = std::max(model.latent_max(r), z);
    }
  });
  const VectorXd margin = (0.1 * (model.latent_max - model.latent_min)).cwiseMax(1e-6);
  model.latent_min -= margin;
  model.latent_max += margin;
  const VectorXd range = (high - low).cwiseMax(1e-3);
  low -= range;
  high += range;
  const ReadingLimits limits(rollout.data(), training.all_noise(), training.input_noise);
  for (std::size_t r = 0; r < limits.low.size(); ++r) {
    if (std::isinf(limits.low[r])) continue;
    low(static_cast<Index>(r)) = static_cast<double>(limits.low[r]);
    high(static_cast<Index>(r)) = static_cast<double>(limits.high[r]);
  }
  model.output_min = low.head(ny);
  model.output_max = high.head(ny);
  const auto inputs = static_cast<Index>(model.inputs.size());
  model.input_min = low.segment(ny, inputs);
  model.input_max = high.segment(ny, inputs);
  // If the readings are within their ranges, an output that is computed from them is within its range.
  const codegen::ComputedOutputs computed(model.outputs, model.inputs);
  for (std::size_t i = 0; i < computed.all().size(); ++i) {
    const auto within = computed.all()[i].evaluate<codegen::Interval>([&](int j) -> codegen::Interval {
      return j < ny ? codegen::Interval(model.output_min(j), model.output_max(j))
                    : codegen::Interval(model.input_min(j - ny), model.input_max(j - ny));
    });
    const double rounding = 1e-6 * std::max(std::abs(within.low), std::abs(within.high));
    const Index row = computed.first() + static_cast<Index>(i);
    model.output_min(row) = within.low - rounding;
    model.output_max(row) = within.high + rounding;
  }
  for (Index j = 0; j < ny; ++j) {
    const double wrap = model.outputs[static_cast<std::size_t>(j)].wrap;
    if (wrap <= 0.0) continue;
    model.output_max(j) = 64.0 * wrap;
    model.output_min(j) = -model.output_max(j);
  }
}

}  // namespace

codegen::Model to_model(const ObserverStructure& structure, const float* parameters, const Experiment& experiment,
                        const Dataset& dataset, const Rollout& rollout) {
  codegen::Model model;
  model.name = experiment.name;
  model.outputs = dataset.outputs;
  model.states = dataset.states;
  if (dataset.reads_inputs) {
    model.inputs = dataset.inputs;
    model.input_hold = experiment.observer.input_hold;
  }
  model.failures = rollout.data().failures;
  model.sample_period_s = dataset.sample_period_s;
  model.hold = experiment.observer.hold;
  model.initial_latent = VectorXd::Zero(structure.latent.rows);
  structure.module->to_model(structure, parameters, experiment, dataset, model);
  set_ranges(model, rollout, experiment.training);
  structure.module->complete(structure, model);
  record_largest_activations(model, rollout);
  record_flight(model, dataset, rollout);
  return model;
}

}  // namespace nlo::trainer
