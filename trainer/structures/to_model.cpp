// SPDX-License-Identifier: MIT
// From flat parameters to a model that flies: names, units, ranges, domain, networks with their normalisation.
#include <algorithm>
#include <limits>

#include "codegen/model/latent_step.h"
#include "trainer/structures/activation_range.h"
#include "trainer/structures/flight_record.h"
#include "trainer/structures/for_each_sample.h"
#include "trainer/structures/module.h"
#include "trainer/structures/structure.h"

namespace nlo::trainer {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The domain: what latent states training has seen, relative to S y for relative outputs, and a tenth of their range
/// more. Outputs: one more range on either side before a measurement is called impossible; angles may count 64 turns.
void set_ranges(codegen::Model& model, const Rollout& rollout) {
  const MatrixXd steady_gain = codegen::steady_gain(model);
  const Index nz = model.nz(), ny = model.ny();
  model.latent_min = VectorXd::Constant(nz, std::numeric_limits<double>::infinity());
  model.latent_max = -model.latent_min;
  VectorXd output_min = VectorXd::Constant(ny, std::numeric_limits<double>::infinity()), output_max = -output_min;
  VectorXd y(ny);
  for_each_sample(rollout, [&](const Segment&, const SegmentGroup& group, int lane, int time) {
    const auto at = [&](const std::vector<float>& signal, Index row) {
      return static_cast<double>(signal[group.at(static_cast<int>(row), time) + static_cast<std::size_t>(lane)]);
    };
    for (Index j = 0; j < ny; ++j) y(j) = at(group.outputs, j);
    output_min = output_min.cwiseMin(y);
    output_max = output_max.cwiseMax(y);
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
  const VectorXd range = (output_max - output_min).cwiseMax(1e-3);
  model.output_min = output_min - range;
  model.output_max = output_max + range;
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
  model.sample_period_s = dataset.sample_period_s;
  model.hold = experiment.observer.hold;
  model.initial_latent = VectorXd::Zero(structure.latent.rows);
  structure.module->to_model(structure, parameters, experiment, dataset, model);
  set_ranges(model, rollout);
  record_largest_activations(model, rollout);
  record_flight(model, dataset, rollout);
  return model;
}

}  // namespace nlo::trainer
