// SPDX-License-Identifier: MIT
#include "trainer/structures/structure.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "codegen/activations.h"
#include "codegen/error.h"
#include "trainer/structures/for_each_sample.h"
#include "trainer/structures/observer_gain.h"

namespace nlo::trainer {

namespace {

Hold hold_named(const std::string& name) {
  if (name == "zero_order") return Hold::kZeroOrder;
  if (name == "first_order") return Hold::kFirstOrder;
  if (name == "rk4") return Hold::kRk4;
  throw codegen::Error("unknown hold \"" + name + "\"; use zero_order, first_order or rk4");
}

std::complex<double> eigenvalue(const Mode& mode, const std::vector<double>& eigenvalues) {
  const auto row = static_cast<std::size_t>(mode.row);
  return {eigenvalues[row], mode.pair ? eigenvalues[row + 1] : 0.0};
}

float target(const Rollout& rollout, const Segment& segment, int state, int time) {
  const TrainingData::Run& run = rollout.data().runs[static_cast<std::size_t>(segment.run)];
  return segment.sign * run.states[static_cast<std::size_t>(state * run.samples + segment.start + time)];
}

/// Weighted mean and deviation, one pass (West 1979).
struct Moments {
  double total = 0.0, mean = 0.0, squares = 0.0;
  void add(double x, double w) {
    if (w <= 0.0) return;
    total += w;
    const double step = x - mean;
    mean += step * w / total;
    squares += w * step * (x - mean);
  }
  double deviation() const { return total > 0.0 ? std::sqrt(squares / total) : 0.0; }
};

/// A scale that is safe to divide by: a signal that does not move keeps its unit.
float safe_scale(double deviation) {
  return deviation > 1e-9 ? static_cast<float>(deviation) : 1.0F;
}

}  // namespace

std::vector<double> ObserverStructure::eigenvalues_at(const float* parameters) const {
  if (!is_kkl()) return {};
  std::vector<double> result = eigenvalues;
  eigenvalues_from_parameters(latent, parameters, result.data());
  return result;
}

namespace {

/// D and F: identity Kronecker (eigenvalues), every output has modes of its own. With one set for all, the latent would
/// see only the sum of the outputs.
void add_modes(ObserverStructure& structure, const ObserverConfig& observer, int ny) {
  LatentShape& latent = structure.latent;
  latent.hold = hold_named(observer.hold);
  latent.injection = observer.output_injection == "unit_gain" ? Injection::kUnitGain : Injection::kOnes;
  latent.starts_steady = observer.start == "steady";
  for (int j = 0; j < ny; ++j) {
    for (const auto& [re, im] : observer.pairs) {
      latent.modes.push_back({.pair = true, .row = latent.rows, .output = j});
      latent.rows += 2;
      structure.eigenvalues.insert(structure.eigenvalues.end(), {re, im});
    }
  }
  for (int j = 0; j < ny; ++j) {
    for (const double lambda : observer.eigenvalues) {
      latent.modes.push_back({.pair = false, .row = latent.rows++, .output = j});
      structure.eigenvalues.push_back(lambda);
    }
  }
  latent.learned = latent.rows;
  for (const double tau_s : observer.clocks_s) {
    latent.modes.push_back({.pair = false, .row = latent.rows++, .output = -1});
    structure.eigenvalues.push_back(-1.0 / tau_s);
  }
  if (latent.learned == 0) throw codegen::Error("the observer has no eigenvalues: set [observer] eigenvalues or pairs");
}

void add_features(ObserverStructure& structure, const ObserverConfig& observer, int ny) {
  const bool relative = observer.features == "latent_minus_output";
  for (const Mode& mode : structure.latent.modes) {
    Feature feature{.latent = mode.row};
    if (relative && mode.output >= 0) {  // unit gain: the steady state of a pair is (y, 0), of a real mode y
      feature.output = mode.output;
      feature.output_gain = -1.0F;
    }
    structure.features.push_back(feature);
    if (mode.pair) structure.features.push_back({.latent = mode.row + 1});
  }
  if (observer.features == "latent_and_output") {
    for (int j = 0; j < ny; ++j) structure.features.push_back({.latent = -1, .output = j, .output_gain = 1.0F});
  }
}

StructureKind kind_named(const std::string& name) {
  if (name == "kkl") return StructureKind::kKkl;
  if (name == "driven_kkl") return StructureKind::kDrivenKkl;
  if (name == "luenberger") return StructureKind::kLuenberger;
  if (name == "general") return StructureKind::kGeneral;
  throw codegen::Error("unknown structure \"" + name + "\"; use kkl, driven_kkl, luenberger or general");
}

NetworkShape network_shape(int inputs, const std::vector<int>& hidden, int outputs, const std::string& activation,
                           bool linear_path) {
  std::vector<int> widths{inputs};
  widths.insert(widths.end(), hidden.begin(), hidden.end());
  widths.push_back(outputs);
  return NetworkShape::make(widths, codegen::activation_named(activation).kind, linear_path);
}

Normalisation no_normalisation(int inputs) {
  const auto count = static_cast<std::size_t>(inputs);
  return {std::vector<double>(count, 0.0), std::vector<double>(count, 1.0)};
}

}  // namespace

ObserverStructure make_structure(const Experiment& experiment, const std::vector<Channel>& outputs,
                                 const std::vector<Channel>& states) {
  const ObserverConfig& observer = experiment.observer;
  const DynamicsConfig& dynamics = experiment.dynamics;
  const int nx = static_cast<int>(states.size()), ny = static_cast<int>(outputs.size());
  ObserverStructure structure;
  structure.kind = kind_named(observer.structure);
  structure.outputs = ny;
  structure.state_mean.assign(states.size(), 0.0F);
  structure.state_scale.assign(states.size(), 1.0F);
  if (structure.kind == StructureKind::kLuenberger) {
    structure.latent.rows = nx;
    structure.latent.hold = hold_named(observer.hold);
    structure.known = linear_part(observer, nx, ny);
    structure.dynamics = {network_shape(nx, dynamics.hidden, nx, dynamics.activation, false), no_normalisation(nx)};
    return structure;
  }
  add_modes(structure, observer, ny);
  add_features(structure, observer, ny);
  const int nz = structure.latent.rows;
  structure.network = network_shape(static_cast<int>(structure.features.size()), experiment.inverse_map.hidden, nx,
                                    experiment.inverse_map.activation, experiment.inverse_map.linear_path);
  if (structure.kind == StructureKind::kGeneral) {
    structure.dynamics = {network_shape(nz + ny, dynamics.hidden, nz, dynamics.activation, true),
                          no_normalisation(nz + ny)};
  }
  if (experiment.uses_forward_map()) {
    structure.forward_map =
        network_shape(nx, experiment.forward_map.hidden, nz, experiment.forward_map.activation, false);
    structure.latent_mean.assign(static_cast<std::size_t>(nz), 0.0F);
    structure.latent_scale.assign(static_cast<std::size_t>(nz), 1.0F);
  }
  return structure;
}

void normalise_dynamics(ObserverStructure& structure, const TrainingData& data, ThreadPool& pool) {
  if (structure.is_kkl()) return;
  std::vector<Moments> inputs(structure.dynamics.inputs.scale.size());
  const auto first_output =
      static_cast<std::size_t>(structure.kind == StructureKind::kGeneral ? structure.latent.rows : 0);
  for (const TrainingData::Run& run : data.runs) {
    const std::vector<float>& signal = structure.kind == StructureKind::kGeneral ? run.outputs : run.states;
    for (std::size_t i = first_output; i < inputs.size(); ++i) {
      const float* row = signal.data() + (i - first_output) * static_cast<std::size_t>(run.samples);
      for (int k = 0; k < run.samples; ++k) inputs[i].add(static_cast<double>(row[k]), 1.0);
    }
  }
  if (structure.kind == StructureKind::kGeneral) {  // z as the linear system has it, about zero
    LinearLatent linear(structure.latent, structure.eigenvalues, data.steps_s, true);
    linear.prepare(parameters_from_eigenvalues(structure.latent, structure.eigenvalues.data()).data());
    Rollout rollout(data);
    rollout.run(whole_runs(data), linear, {}, 0, Purpose::kValidationNoise, 0, pool);
    for_each_sample(rollout, [&](const Segment&, const SegmentGroup& group, int lane, int time) {
      for (std::size_t r = 0; r < first_output; ++r) {
        inputs[r].add(
            static_cast<double>(group.latent[group.at(static_cast<int>(r), time) + static_cast<std::size_t>(lane)]),
            1.0);
      }
    });
    for (std::size_t r = 0; r < first_output; ++r) inputs[r].mean = 0.0;
  }
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    structure.dynamics.inputs.mean[i] = inputs[i].mean;
    structure.dynamics.inputs.scale[i] = static_cast<double>(safe_scale(inputs[i].deviation()));
  }
}

std::vector<float> initial_dynamics(const ObserverStructure& structure, const Experiment& experiment) {
  constexpr std::uint64_t kStream = 1;
  if (structure.is_kkl()) return parameters_from_eigenvalues(structure.latent, structure.eigenvalues.data());
  const NetworkShape& shape = structure.dynamics.shape;
  if (structure.kind == StructureKind::kLuenberger) return initial_parameters(shape, experiment.seed, 1.0F, kStream);

  // F(z, y) = D z + F y at first: the linear path alone, in the units of its inputs.
  std::vector<float> parameters = initial_parameters(shape, experiment.seed, 0.0F, kStream);
  const Normalisation& inputs = structure.dynamics.inputs;
  float* bias = parameters.data() + shape.layers.back().bias;
  const auto set = [&](int row, int column, double value) {
    const auto c = static_cast<std::size_t>(column);
    parameters[static_cast<std::size_t>(shape.linear_path + row * shape.inputs() + column)] =
        static_cast<float>(value * inputs.scale[c]);
    bias[row] += static_cast<float>(value * inputs.mean[c]);
  };
  for (const Mode& mode : structure.latent.modes) {
    const std::complex<double> lambda = eigenvalue(mode, structure.eigenvalues);
    const std::complex<double> f = injection_of(structure.latent.injection, mode, lambda);
    set(mode.row, mode.row, lambda.real());
    if (mode.output >= 0) set(mode.row, structure.latent.rows + mode.output, f.real());
    if (!mode.pair) continue;
    set(mode.row, mode.row + 1, -lambda.imag());
    set(mode.row + 1, mode.row, lambda.imag());
    set(mode.row + 1, mode.row + 1, lambda.real());
    if (mode.output >= 0) set(mode.row + 1, structure.latent.rows + mode.output, f.imag());
  }
  return parameters;
}

void normalise(ObserverStructure& structure, const Rollout& rollout) {
  std::vector<Moments> features(structure.features.size());
  std::vector<Moments> states(structure.state_mean.size());
  std::vector<Moments> latent(structure.latent_mean.size());
  for_each_sample(rollout, [&](const Segment& segment, const SegmentGroup& group, int lane, int time) {
    for (std::size_t f = 0; f < features.size(); ++f) {
      features[f].add(static_cast<double>(feature_value(structure.features[f], group, lane, time)), 1.0);
    }
    const auto w = static_cast<double>(weight(rollout, segment, time));
    for (std::size_t i = 0; i < states.size(); ++i) {
      states[i].add(static_cast<double>(target(rollout, segment, static_cast<int>(i), time)), w);
    }
    for (std::size_t r = 0; r < latent.size(); ++r) {
      latent[r].add(
          static_cast<double>(group.latent[group.at(static_cast<int>(r), time) + static_cast<std::size_t>(lane)]), w);
    }
  });
  for (std::size_t f = 0; f < features.size(); ++f) {
    structure.features[f].mean = static_cast<float>(features[f].mean);
    structure.features[f].scale = safe_scale(features[f].deviation());
    // A clock runs from 1 to 0, known without data; most samples are late, so their deviation says nothing of its
    // start.
    if (is_clock(structure, structure.features[f])) structure.features[f].mean = structure.features[f].scale = 0.5F;
  }
  for (std::size_t i = 0; i < states.size(); ++i) {
    structure.state_mean[i] = static_cast<float>(states[i].mean);
    structure.state_scale[i] = safe_scale(states[i].deviation());
  }
  for (std::size_t r = 0; r < latent.size(); ++r) {
    structure.latent_mean[r] = static_cast<float>(latent[r].mean);
    structure.latent_scale[r] = safe_scale(latent[r].deviation());
  }
}

std::vector<float> initial_parameters(const ObserverStructure& structure, const Experiment& experiment,
                                      const Rollout& rollout) {
  std::vector<float> parameters = initial_dynamics(structure, experiment);
  if (structure.features.empty()) return parameters;
  // Beside a linear path the network starts as no correction at all: exactly from the ridge regression.
  const bool linear = structure.network.linear_path >= 0;
  const std::vector<float> network = initial_parameters(structure.network, experiment.seed, linear ? 0.0F : 1.0F);
  parameters.insert(parameters.end(), network.begin(), network.end());
  if (structure.forward_map) {
    constexpr std::uint64_t kStream = 2;
    const std::vector<float> map = initial_parameters(*structure.forward_map, experiment.seed, 1.0F, kStream);
    parameters.insert(parameters.end(), map.begin(), map.end());
  }
  if (!linear) return parameters;

  const auto nf = static_cast<Eigen::Index>(structure.features.size());
  const auto nx = static_cast<Eigen::Index>(structure.state_mean.size());
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(nf, nf);
  Eigen::MatrixXd moment = Eigen::MatrixXd::Zero(nf, nx);
  Eigen::VectorXd u(nf);
  Eigen::VectorXd x(nx);
  double total = 0.0;
  for_each_sample(rollout, [&](const Segment& segment, const SegmentGroup& group, int lane, int time) {
    const auto w = static_cast<double>(weight(rollout, segment, time));
    if (w == 0.0) return;
    for (Eigen::Index f = 0; f < nf; ++f) {
      const Feature& feature = structure.features[static_cast<std::size_t>(f)];
      u(f) = static_cast<double>((feature_value(feature, group, lane, time) - feature.mean) / feature.scale);
    }
    for (Eigen::Index i = 0; i < nx; ++i) {
      const auto s = static_cast<std::size_t>(i);
      x(i) = static_cast<double>((target(rollout, segment, static_cast<int>(i), time) - structure.state_mean[s]) /
                                 structure.state_scale[s]);
    }
    gram.selfadjointView<Eigen::Lower>().rankUpdate(u, w);
    moment.noalias() += w * u * x.transpose();
    total += w;
  });
  gram.diagonal().array() += experiment.inverse_map.ridge * total;  // features have unit power: so has the mean of gram
  const Eigen::MatrixXd path = gram.selfadjointView<Eigen::Lower>().ldlt().solve(moment);
  float* out = parameters.data() + structure.dynamics_parameters() + structure.network.linear_path;
  for (Eigen::Index i = 0; i < nx; ++i) {
    for (Eigen::Index f = 0; f < nf; ++f) out[i * nf + f] = static_cast<float>(path(f, i));
  }
  return parameters;
}

}  // namespace nlo::trainer
