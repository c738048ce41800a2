// SPDX-License-Identifier: MIT
#include "trainer/structures/kkl.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "codegen/error.h"

namespace nlo::trainer {

namespace {

Hold hold_named(const std::string& name) {
  if (name == "zero_order") return Hold::kZeroOrder;
  if (name == "first_order") return Hold::kFirstOrder;
  if (name == "rk4") return Hold::kRk4;
  throw codegen::Error("unknown hold \"" + name + "\"; use zero_order, first_order or rk4");
}

Activation activation_named(const std::string& name) {
  if (name == "tanh") return Activation::kTanh;
  if (name == "relu") return Activation::kRelu;
  if (name == "silu") return Activation::kSilu;
  throw codegen::Error("unknown activation \"" + name + "\"; use tanh, relu or silu");
}

std::complex<double> eigenvalue(const Mode& mode, const std::vector<double>& eigenvalues) {
  const auto row = static_cast<std::size_t>(mode.row);
  return {eigenvalues[row], mode.pair ? eigenvalues[row + 1] : 0.0};
}

/// Calls visit(segment, group, lane, time) for every recorded sample of a rollout.
template <class Visit>
void for_each_sample(Rollout& rollout, const Visit& visit) {
  for (std::size_t g = 0; g < rollout.groups().size(); ++g) {
    const SegmentGroup& group = rollout.groups()[g];
    for (int l = 0; l < group.lanes; ++l) {
      const Segment& segment = rollout.segment(static_cast<int>(g), l);
      for (int t = 0; t < segment.length; ++t) visit(segment, group, l, t);
    }
  }
}

float feature_value(const Feature& feature, const SegmentGroup& group, int lane, int time) {
  float u = 0.0F;
  if (feature.latent >= 0) u += group.latent[group.at(feature.latent, time) + static_cast<std::size_t>(lane)];
  if (feature.output >= 0) {
    u += feature.output_gain * group.outputs[group.at(feature.output, time) + static_cast<std::size_t>(lane)];
  }
  return u;
}

float target(const Rollout& rollout, const Segment& segment, int state, int time) {
  const TrainingData::Run& run = rollout.data().runs[static_cast<std::size_t>(segment.run)];
  return segment.sign * run.states[static_cast<std::size_t>(state * run.samples + segment.start + time)];
}

float weight(const Rollout& rollout, const Segment& segment, int time) {
  return rollout.data()
      .runs[static_cast<std::size_t>(segment.run)]
      .weight[static_cast<std::size_t>(segment.start + time)];
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

std::vector<double> KklStructure::eigenvalues_at(const float* parameters) const {
  std::vector<double> result = eigenvalues;
  eigenvalues_from_parameters(latent, parameters, result.data());
  return result;
}

KklStructure make_structure(const Experiment& experiment, const std::vector<Channel>& outputs,
                            const std::vector<Channel>& states) {
  const ObserverConfig& observer = experiment.observer;
  KklStructure structure;
  LatentShape& latent = structure.latent;
  latent.hold = hold_named(observer.hold);
  latent.injection = observer.output_injection == "unit_gain" ? Injection::kUnitGain : Injection::kOnes;
  latent.starts_steady = observer.start == "steady";
  // Identity Kronecker (eigenvalues): every output has modes of its own. With one set for all, the latent would see
  // only the sum of the outputs.
  const int ny = static_cast<int>(outputs.size());
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

  const bool relative = observer.features == "latent_minus_output";
  for (const Mode& mode : latent.modes) {
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

  std::vector<int> widths{static_cast<int>(structure.features.size())};
  widths.insert(widths.end(), experiment.inverse_map.hidden.begin(), experiment.inverse_map.hidden.end());
  widths.push_back(static_cast<int>(states.size()));
  structure.network = NetworkShape::make(widths, activation_named(experiment.inverse_map.activation),
                                         experiment.inverse_map.linear_path);
  structure.state_mean.assign(states.size(), 0.0F);
  structure.state_scale.assign(states.size(), 1.0F);
  return structure;
}

void normalise(KklStructure& structure, Rollout& rollout) {
  std::vector<Moments> features(structure.features.size());
  std::vector<Moments> states(structure.state_mean.size());
  for_each_sample(rollout, [&](const Segment& segment, const SegmentGroup& group, int lane, int time) {
    for (std::size_t f = 0; f < features.size(); ++f) {
      features[f].add(static_cast<double>(feature_value(structure.features[f], group, lane, time)), 1.0);
    }
    const auto w = static_cast<double>(weight(rollout, segment, time));
    for (std::size_t i = 0; i < states.size(); ++i) {
      states[i].add(static_cast<double>(target(rollout, segment, static_cast<int>(i), time)), w);
    }
  });
  for (std::size_t f = 0; f < features.size(); ++f) {
    structure.features[f].mean = static_cast<float>(features[f].mean);
    structure.features[f].scale = safe_scale(features[f].deviation());
  }
  for (std::size_t i = 0; i < states.size(); ++i) {
    structure.state_mean[i] = static_cast<float>(states[i].mean);
    structure.state_scale[i] = safe_scale(states[i].deviation());
  }
}

std::vector<float> initial_parameters(const KklStructure& structure, const Experiment& experiment, Rollout& rollout) {
  std::vector<float> parameters = parameters_from_eigenvalues(structure.latent, structure.eigenvalues.data());
  // Beside a linear path the network starts as no correction at all: exactly from the ridge regression.
  const bool linear = structure.network.linear_path >= 0;
  const std::vector<float> network = initial_parameters(structure.network, experiment.seed, linear ? 0.0F : 1.0F);
  parameters.insert(parameters.end(), network.begin(), network.end());
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
  float* out = parameters.data() + structure.latent.learned + structure.network.linear_path;
  for (Eigen::Index i = 0; i < nx; ++i) {
    for (Eigen::Index f = 0; f < nf; ++f) out[i * nf + f] = static_cast<float>(path(f, i));
  }
  return parameters;
}

codegen::Model to_model(const KklStructure& structure, const float* parameters, const Experiment& experiment,
                        const Dataset& dataset, Rollout& rollout) {
  const LatentShape& latent = structure.latent;
  const auto nz = static_cast<Eigen::Index>(latent.rows);
  const auto ny = static_cast<Eigen::Index>(dataset.outputs.size());
  const auto nf = static_cast<Eigen::Index>(structure.features.size());
  const std::vector<double> eigenvalues = structure.eigenvalues_at(parameters);

  codegen::Model model;
  model.name = experiment.name;
  model.outputs = dataset.outputs;
  model.states = dataset.states;
  model.sample_period_s = dataset.sample_period_s;
  model.hold = experiment.observer.hold;
  model.eigenvalues = Eigen::Map<const Eigen::VectorXd>(eigenvalues.data(), nz);
  model.output_injection = Eigen::MatrixXd::Zero(nz, ny);
  model.initial_latent = Eigen::VectorXd::Zero(nz);
  model.starts_steady = latent.starts_steady;
  Eigen::MatrixXd steady_gain = Eigen::MatrixXd::Zero(nz, ny);
  for (const Mode& mode : latent.modes) {
    if (mode.pair) ++model.pairs;
    if (mode.output < 0) {
      model.initial_latent(mode.row) = 1.0;
      continue;
    }
    const std::complex<double> lambda = eigenvalue(mode, eigenvalues);
    const std::complex<double> f = injection_of(latent.injection, mode, lambda);
    const std::complex<double> s = -f / lambda;
    model.output_injection(mode.row, mode.output) = f.real();
    steady_gain(mode.row, mode.output) = s.real();
    if (mode.pair) {
      model.output_injection(mode.row + 1, mode.output) = f.imag();
      steady_gain(mode.row + 1, mode.output) = s.imag();
    }
  }

  // The domain: what latent states training has seen, relative to S y for angles, and a tenth of their range more.
  model.latent_min = Eigen::VectorXd::Constant(nz, std::numeric_limits<double>::infinity());
  model.latent_max = -model.latent_min;
  Eigen::VectorXd output_min = Eigen::VectorXd::Constant(ny, std::numeric_limits<double>::infinity());
  Eigen::VectorXd output_max = -output_min;
  for_each_sample(rollout, [&](const Segment&, const SegmentGroup& group, int lane, int time) {
    for (Eigen::Index j = 0; j < ny; ++j) {
      const auto y =
          static_cast<double>(group.outputs[group.at(static_cast<int>(j), time) + static_cast<std::size_t>(lane)]);
      output_min(j) = std::min(output_min(j), y);
      output_max(j) = std::max(output_max(j), y);
    }
    for (Eigen::Index r = 0; r < nz; ++r) {
      auto z = static_cast<double>(group.latent[group.at(static_cast<int>(r), time) + static_cast<std::size_t>(lane)]);
      for (Eigen::Index j = 0; j < ny; ++j) {
        if (dataset.outputs[static_cast<std::size_t>(j)].wrap <= 0.0) continue;
        z -= steady_gain(r, j) *
             static_cast<double>(group.outputs[group.at(static_cast<int>(j), time) + static_cast<std::size_t>(lane)]);
      }
      model.latent_min(r) = std::min(model.latent_min(r), z);
      model.latent_max(r) = std::max(model.latent_max(r), z);
    }
  });
  const Eigen::VectorXd margin = (0.1 * (model.latent_max - model.latent_min)).cwiseMax(1e-6);
  model.latent_min -= margin;
  model.latent_max += margin;
  // Outputs: one more range on either side before a measurement is called impossible; angles may count 64 turns.
  const Eigen::VectorXd range = (output_max - output_min).cwiseMax(1e-3);
  model.output_min = output_min - range;
  model.output_max = output_max + range;
  for (Eigen::Index j = 0; j < ny; ++j) {
    const double wrap = dataset.outputs[static_cast<std::size_t>(j)].wrap;
    if (wrap <= 0.0) continue;
    model.output_max(j) = 64.0 * wrap;
    model.output_min(j) = -model.output_max(j);
  }

  codegen::Network& map = model.inverse_map;
  map.features = Eigen::MatrixXd::Zero(nf, nz + ny);
  map.feature_mean.resize(nf);
  map.feature_scale.resize(nf);
  for (Eigen::Index f = 0; f < nf; ++f) {
    const Feature& feature = structure.features[static_cast<std::size_t>(f)];
    if (feature.latent >= 0) map.features(f, feature.latent) = 1.0;
    if (feature.output >= 0) map.features(f, nz + feature.output) = static_cast<double>(feature.output_gain);
    map.feature_mean(f) = static_cast<double>(feature.mean);
    map.feature_scale(f) = static_cast<double>(feature.scale);
  }
  map.activation = experiment.inverse_map.activation;
  const float* network = parameters + latent.learned;
  using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  for (const LayerView& layer : structure.network.layers) {
    map.layers.push_back({Eigen::Map<const RowMajor>(network + layer.weights, layer.out, layer.in).cast<double>(),
                          Eigen::Map<const Eigen::VectorXf>(network + layer.bias, layer.out).cast<double>()});
  }
  const auto nx = static_cast<Eigen::Index>(dataset.states.size());
  if (structure.network.linear_path >= 0) {
    map.skip = Eigen::Map<const RowMajor>(network + structure.network.linear_path, nx, nf).cast<double>();
  }
  map.output_mean = Eigen::Map<const Eigen::VectorXf>(structure.state_mean.data(), nx).cast<double>();
  map.output_scale = Eigen::Map<const Eigen::VectorXf>(structure.state_scale.data(), nx).cast<double>();
  return model;
}

}  // namespace nlo::trainer
