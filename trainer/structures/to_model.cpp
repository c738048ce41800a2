// SPDX-License-Identifier: MIT
// From flat parameters to a model that flies: names, units, ranges, domain, networks with their normalisation.
#include <algorithm>
#include <complex>
#include <limits>

#include "codegen/hold.h"
#include "trainer/structures/activation_range.h"
#include "trainer/structures/flight_record.h"
#include "trainer/structures/for_each_sample.h"
#include "trainer/structures/structure.h"

namespace nlo::trainer {

namespace {

using Eigen::Index;

Hold hold_named(const std::string& name) {
  return codegen::find_hold(name).value_or(Hold::kFirstOrder);  // checked when the experiment was read
}
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd to_double(const std::vector<float>& values) {
  return Eigen::Map<const Eigen::VectorXf>(values.data(), static_cast<Index>(values.size())).cast<double>();
}

/// The layers and the linear path of a network; features and scales are the caller's.
codegen::Network network_of(const NetworkShape& shape, const float* parameters) {
  using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  codegen::Network network;
  network.activation = shape.activation;
  for (const LayerView& layer : shape.layers) {
    network.layers.push_back(
        {Eigen::Map<const RowMajor>(parameters + layer.weights, layer.out, layer.in).cast<double>(),
         Eigen::Map<const Eigen::VectorXf>(parameters + layer.bias, layer.out).cast<double>()});
  }
  if (shape.linear_path >= 0) {
    network.skip =
        Eigen::Map<const RowMajor>(parameters + shape.linear_path, shape.outputs(), shape.inputs()).cast<double>();
  }
  return network;
}

/// A network of normalised inputs: u = (in - mean) / scale, outputs in their own units.
codegen::Network dynamics_of(const DynamicsNetwork& dynamics, const float* parameters) {
  const auto inputs = static_cast<Index>(dynamics.inputs.mean.size());
  codegen::Network network = network_of(dynamics.shape, parameters);
  network.features = MatrixXd::Identity(inputs, inputs);
  network.feature_mean = Eigen::Map<const VectorXd>(dynamics.inputs.mean.data(), inputs);
  network.feature_scale = Eigen::Map<const VectorXd>(dynamics.inputs.scale.data(), inputs);
  network.output_mean = VectorXd::Zero(dynamics.shape.outputs());
  network.output_scale = VectorXd::Ones(dynamics.shape.outputs());
  return network;
}

codegen::Network inverse_map_of(const ObserverStructure& structure, const float* parameters, Index ny) {
  const auto nf = static_cast<Index>(structure.features.size());
  const Index nz = structure.latent.rows;
  codegen::Network map = network_of(structure.network, parameters);
  map.features = MatrixXd::Zero(nf, structure.kind == StructureKind::kGeneral ? nz : nz + ny);  // G of (11) reads z
  map.feature_mean.resize(nf);
  map.feature_scale.resize(nf);
  for (Index f = 0; f < nf; ++f) {
    const Feature& feature = structure.features[static_cast<std::size_t>(f)];
    if (feature.latent >= 0) map.features(f, feature.latent) = 1.0;
    if (feature.output >= 0) map.features(f, nz + feature.output) = static_cast<double>(feature.output_gain);
    map.feature_mean(f) = static_cast<double>(feature.mean);
    map.feature_scale(f) = static_cast<double>(feature.scale);
  }
  map.output_mean = to_double(structure.state_mean);
  map.output_scale = to_double(structure.state_scale);
  return map;
}

codegen::Network forward_map_of(const ObserverStructure& structure, const float* parameters) {
  const auto nx = static_cast<Index>(structure.state_mean.size());
  codegen::Network map = network_of(*structure.forward_map, parameters);
  map.features = MatrixXd::Identity(nx, nx);
  map.feature_mean = to_double(structure.state_mean);
  map.feature_scale = to_double(structure.state_scale);
  map.output_mean = to_double(structure.latent_mean);
  map.output_scale = to_double(structure.latent_scale);
  return map;
}

/// D, F and z(0); returns S, the latent state per unit of a steady output.
MatrixXd set_linear_latent(codegen::Model& model, const ObserverStructure& structure, const float* parameters) {
  const LatentShape& latent = structure.latent;
  const std::vector<double> eigenvalues = structure.eigenvalues_at(parameters);
  codegen::LinearLatent& own = *codegen::linear_latent(model);
  own.eigenvalues = Eigen::Map<const VectorXd>(eigenvalues.data(), latent.rows);
  own.output_injection = MatrixXd::Zero(latent.rows, model.ny());
  own.starts_steady = latent.starts_steady;
  MatrixXd steady_gain = own.output_injection;
  for (const Mode& mode : latent.modes) {
    if (mode.pair) ++own.pairs;
    if (mode.output < 0) {
      model.initial_latent(mode.row) = 1.0;
      continue;
    }
    const auto row = static_cast<std::size_t>(mode.row);
    const std::complex<double> lambda{eigenvalues[row], mode.pair ? eigenvalues[row + 1] : 0.0};
    const std::complex<double> f = injection_of(latent.injection, mode, lambda);
    const std::complex<double> s = -f / lambda;
    own.output_injection(mode.row, mode.output) = f.real();
    steady_gain(mode.row, mode.output) = s.real();
    if (!mode.pair) continue;
    own.output_injection(mode.row + 1, mode.output) = f.imag();
    steady_gain(mode.row + 1, mode.output) = s.imag();
  }
  return steady_gain;
}

/// The domain: what latent states training has seen, relative to S y for relative outputs, and a tenth of their
/// range more.
/// Outputs: one more range on either side before a measurement is called impossible; angles may count 64 turns.
void set_ranges(codegen::Model& model, const Rollout& rollout, const MatrixXd& steady_gain) {
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
  model.hold = hold_named(experiment.observer.hold);
  model.initial_latent = VectorXd::Zero(structure.latent.rows);
  MatrixXd steady_gain = MatrixXd::Zero(structure.latent.rows, model.ny());
  const float* network = parameters + structure.dynamics_parameters();
  const float* forward_map = network + structure.network.parameters;
  switch (structure.kind) {
    case StructureKind::kKkl:
      break;
    case StructureKind::kDrivenKkl: {
      codegen::DrivenKkl& own = model.structure.emplace<codegen::DrivenKkl>();
      own.inputs = dataset.inputs;
      own.input_hold = hold_named(experiment.observer.input_hold);
      own.input_field = dataset.input_field;
      own.forward_map = forward_map_of(structure, forward_map);
      break;
    }
    case StructureKind::kLuenberger:
      model.structure = codegen::Luenberger{.state_matrix = structure.known.state_matrix,
                                            .output_matrix = structure.known.output_matrix,
                                            .gain = structure.known.gain,
                                            .nonlinearity = dynamics_of(structure.dynamics, parameters)};
      break;
    case StructureKind::kGeneral:
      model.structure.emplace<codegen::General>().dynamics = dynamics_of(structure.dynamics, parameters);
      break;
  }
  if (structure.is_kkl()) steady_gain = set_linear_latent(model, structure, parameters);
  // Every feature of an output is z - y then, and S is one: a rig that rests elsewhere is in the domain all the same.
  if (experiment.observer.features == "latent_minus_output" && structure.latent.injection == Injection::kUnitGain)
    for (int j = 0; j < model.ny(); ++j)
      if (!is_relative(model, j)) codegen::linear_latent(model)->relative_outputs.push_back(j);
  if (codegen::Network* map = codegen::inverse_map(model)) *map = inverse_map_of(structure, network, model.ny());
  set_ranges(model, rollout, steady_gain);
  record_largest_activations(model, rollout);
  record_flight(model, dataset, rollout);
  return model;
}

}  // namespace nlo::trainer
