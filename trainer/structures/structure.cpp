// SPDX-License-Identifier: MIT
#include "trainer/structures/structure.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "codegen/base/linear_algebra.h"
#include "trainer/base/ridge.h"
#include "trainer/structures/dynamics_network.h"
#include "trainer/structures/for_each_sample.h"
#include "trainer/structures/moments.h"
#include "trainer/structures/structure_table.h"

namespace nlo::trainer {

std::vector<double> ObserverStructure::eigenvalues_at(const float* parameters) const {
  if (latent.learned == 0) return {};
  std::vector<double> result = eigenvalues;
  eigenvalues_from_parameters(latent, parameters, result.data());
  return result;
}

ObserverStructure make_structure(const Experiment& experiment, bool trains_forward_map,
                                 const std::vector<Channel>& outputs, const std::vector<Channel>& states,
                                 const std::vector<Channel>& read_inputs, int failing) {
  const int nx = static_cast<int>(states.size());
  ObserverStructure structure;
  structure.module = &structure_of(experiment.observer);
  structure.inputs = static_cast<int>(read_inputs.size());
  structure.failing = failing;
  structure.readings = static_cast<int>(outputs.size()) + structure.inputs + failing;
  structure.state_mean.assign(states.size(), 0.0F);
  structure.state_scale.assign(states.size(), 1.0F);
  structure.latent.hold = experiment.observer.hold;
  if (experiment.observer.input_hold == Hold::kZeroOrder) structure.latent.commands_from = structure.outputs();
  structure.module->make(experiment, structure);
  if (!structure.module->has_inverse_map()) return structure;
  structure.network = network_shape(static_cast<int>(structure.features.size()), experiment.inverse_map.hidden, nx,
                                    experiment.inverse_map.activation, experiment.inverse_map.linear_path);
  if (trains_forward_map || structure.module->flies_forward_map()) {
    const int nz = structure.latent.rows;
    structure.forward_map =
        network_shape(nx, experiment.forward_map.hidden, nz, experiment.forward_map.activation, false);
    structure.latent_mean.assign(static_cast<std::size_t>(nz), 0.0F);
    structure.latent_scale.assign(static_cast<std::size_t>(nz), 1.0F);
  }
  return structure;
}

void normalise_dynamics(ObserverStructure& structure, const TrainingData& data, ThreadPool& pool) {
  structure.module->normalise_dynamics(structure, data, pool);
}

void check_start(const Experiment& experiment, const Dataset& training) {
  ObserverStructure structure =
      make_structure(experiment, false, training.outputs, training.states, training.inputs_read());
  ThreadPool pool(1);
  normalise_dynamics(structure, TrainingData(training), pool);
}

bool starts_as_estimator(const ObserverStructure& structure) {
  for (std::size_t i = 0; i < structure.state_mean.size(); ++i)
    if (structure.module->estimate_row(structure, static_cast<int>(i)) < 0) return false;
  return structure.network.linear_path >= 0;
}

bool latent_system_learns(const Experiment& experiment, const ObserverStructure& structure) {
  const bool has_network = structure.dynamics.shape.parameters > 0;
  return has_network || (structure.latent.learned > 0 && experiment.observer.learn_eigenvalues);
}

std::vector<float> initial_dynamics(const ObserverStructure& structure, const Experiment& experiment) {
  return structure.module->initial_dynamics(structure, experiment);
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
      states[i].add(static_cast<double>(rollout.state(segment, static_cast<std::size_t>(i), time)), w);
    }
    for (std::size_t r = 0; r < latent.size(); ++r) {
      latent[r].add(
          static_cast<double>(group.latent[group.at(static_cast<int>(r), time) + static_cast<std::size_t>(lane)]), w);
    }
  });
  for (std::size_t f = 0; f < features.size(); ++f) {
    structure.features[f].mean = static_cast<float>(features[f].mean);
    structure.features[f].scale = safe_scale(features[f].deviation());
    // A clock falls from 1 to 0, so its range is known without data. Most samples are late, when the clock is near 0,
    // so their deviation is too small for its start.
    if (is_clock(structure, structure.features[f])) structure.features[f].mean = structure.features[f].scale = 0.5F;
  }
  for (Feature& feature : structure.features) {
    if (feature.without < 0) continue;
    const Feature& same = structure.features[static_cast<std::size_t>(feature.without)];
    feature.mean = same.mean;
    feature.scale = same.scale;
  }
  for (std::size_t i = 0; i < states.size(); ++i) {
    structure.state_mean[i] = static_cast<float>(states[i].mean);
    structure.state_scale[i] = safe_scale(states[i].deviation());
  }
  // All components of a vector get the same scale and mean 0, because another mean would prefer a direction. The same
  // code handles single components.
  const auto axes = static_cast<std::size_t>(structure.axes);
  const auto lengths = [&](const std::vector<Moments>& moments, const auto& set) {
    for (std::size_t first = 0; structure.centred && first < moments.size(); first += axes) {
      double squares = 0.0;
      for (std::size_t c = first; c < first + axes; ++c)
        squares += moments[c].mean * moments[c].mean + moments[c].deviation() * moments[c].deviation();
      const float scale = safe_scale(std::sqrt(squares / static_cast<double>(axes)));
      for (std::size_t c = first; c < first + axes; ++c) set(c, scale);
    }
  };
  lengths(features, [&](std::size_t f, float scale) {
    structure.features[f].mean = 0.0F;
    structure.features[f].scale = scale;
  });
  lengths(states, [&](std::size_t i, float scale) {
    structure.state_mean[i] = 0.0F;
    structure.state_scale[i] = scale;
  });
  for (std::size_t r = 0; r < latent.size(); ++r) {
    structure.latent_mean[r] = static_cast<float>(latent[r].mean);
    structure.latent_scale[r] = safe_scale(latent[r].deviation());
  }
}

namespace {

bool reads_clock_products(const ObserverStructure& structure) {
  return std::any_of(structure.features.begin(), structure.features.end(),
                     [](const Feature& feature) { return feature.clock >= 0; });
}

/// Sets the linear path of `map` to each state's estimate_row().
void write_estimate_rows(const ObserverStructure& structure, float* map) {
  for (std::size_t i = 0; i < structure.state_mean.size(); ++i) {
    const int row = structure.module->estimate_row(structure, static_cast<int>(i));
    for (std::size_t f = 0; f < structure.features.size(); ++f) {
      const Feature& feature = structure.features[f];
      if (feature.latent != row || feature.reading >= 0 || feature.clock >= 0) continue;
      map[structure.network.layers.back().bias + static_cast<std::ptrdiff_t>(i)] =
          (feature.mean - structure.state_mean[i]) / structure.state_scale[i];
      map[static_cast<std::size_t>(structure.network.linear_path) + i * structure.features.size() + f] =
          feature.scale / structure.state_scale[i];
    }
  }
}

/// Returns [intercept, linear path], n_x x (1 + n_u), of a T* that changes with time during the transient.
Eigen::MatrixXd transient_fit(const ObserverStructure& structure, double ridge, const Rollout& rollout) {
  constexpr Eigen::Index kBlock = 4096;  // samples
  const auto nf = static_cast<Eigen::Index>(structure.features.size());
  const auto nx = static_cast<Eigen::Index>(structure.state_mean.size());
  TransientRidge fit;
  Eigen::MatrixXd u(nf, kBlock), x(nx, kBlock);
  Eigen::VectorXd weights(kBlock);
  std::vector<int> since_start;
  const auto add_block = [&] {
    const auto count = static_cast<Eigen::Index>(since_start.size());
    if (count > 0) fit.add(u.leftCols(count), x.leftCols(count), weights.head(count), since_start);
    since_start.clear();
  };
  for_each_sample(rollout, [&](const Segment& segment, const SegmentGroup& group, int lane, int time) {
    const auto w = static_cast<double>(weight(rollout, segment, time));
    if (w == 0.0) return;
    const auto k = static_cast<Eigen::Index>(since_start.size());
    for (Eigen::Index f = 0; f < nf; ++f)
      u(f, k) =
          static_cast<double>(normalised_feature(structure.features[static_cast<std::size_t>(f)], group, lane, time));
    for (Eigen::Index i = 0; i < nx; ++i) {
      const auto s = static_cast<std::size_t>(i);
      x(i, k) =
          static_cast<double>((rollout.state(segment, s, time) - structure.state_mean[s]) / structure.state_scale[s]);
    }
    weights(k) = w;
    since_start.push_back(time);
    if (k + 1 == kBlock) add_block();
  });
  add_block();
  return fit.fit(ridge);
}

}  // namespace

std::vector<float> initial_parameters(const ObserverStructure& structure, const Experiment& experiment,
                                      const Rollout& rollout) {
  std::vector<float> parameters = initial_dynamics(structure, experiment);
  if (structure.features.empty()) return parameters;
  // With a linear path the network starts at exactly zero, so that T* is the ridge regression.
  const bool linear = structure.network.linear_path >= 0;
  const std::vector<float> network = initial_parameters(structure.network, experiment.seed, linear ? 0.0F : 1.0F);
  parameters.insert(parameters.end(), network.begin(), network.end());
  if (structure.forward_map) {
    constexpr std::uint64_t kStream = 2;
    const std::vector<float> map = initial_parameters(*structure.forward_map, experiment.seed, 1.0F, kStream);
    parameters.insert(parameters.end(), map.begin(), map.end());
  }
  if (!linear) return parameters;
  if (starts_as_estimator(structure)) {
    write_estimate_rows(structure, parameters.data() + structure.dynamics_parameters());
    return parameters;
  }
  if (reads_clock_products(structure)) {
    const Eigen::MatrixXd fit = transient_fit(structure, experiment.inverse_map.ridge, rollout);
    float* map = parameters.data() + structure.dynamics_parameters();
    for (Eigen::Index i = 0; i < fit.rows(); ++i) {
      map[structure.network.layers.back().bias + i] = static_cast<float>(fit(i, 0));
      for (Eigen::Index f = 0; f + 1 < fit.cols(); ++f)
        map[structure.network.linear_path + i * (fit.cols() - 1) + f] = static_cast<float>(fit(i, 1 + f));
    }
    return parameters;
  }

  // Each component of a vector is one more sample for the same weights.
  const auto axes = static_cast<Eigen::Index>(structure.axes);
  const auto nf = static_cast<Eigen::Index>(structure.features.size()) / axes;
  const auto nx = static_cast<Eigen::Index>(structure.state_mean.size()) / axes;
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(nf, nf);
  Eigen::MatrixXd moment = Eigen::MatrixXd::Zero(nf, nx);
  Eigen::VectorXd u(nf);
  Eigen::VectorXd x(nx);
  double total = 0.0;
  for_each_sample(rollout, [&](const Segment& segment, const SegmentGroup& group, int lane, int time) {
    const auto w = static_cast<double>(weight(rollout, segment, time));
    if (w == 0.0) return;
    for (Eigen::Index c = 0; c < axes; ++c) {
      for (Eigen::Index f = 0; f < nf; ++f) {
        const Feature& feature = structure.features[static_cast<std::size_t>(f * axes + c)];
        u(f) = static_cast<double>(normalised_feature(feature, group, lane, time));
      }
      for (Eigen::Index i = 0; i < nx; ++i) {
        const auto s = static_cast<std::size_t>(i * axes + c);
        x(i) =
            static_cast<double>((rollout.state(segment, s, time) - structure.state_mean[s]) / structure.state_scale[s]);
      }
      gram.selfadjointView<Eigen::Lower>().rankUpdate(u, w);
      moment.noalias() += w * u * x.transpose();
      total += w;
    }
  });
  // Features have unit power, so the mean diagonal entry of gram is `total`. The ridge is relative to it.
  gram.diagonal().array() += experiment.inverse_map.ridge * total;
  const Eigen::MatrixXd path = codegen::solve_symmetric(gram, moment);
  float* out = parameters.data() + structure.dynamics_parameters() + structure.network.linear_path;
  for (Eigen::Index i = 0; i < nx; ++i)
    for (Eigen::Index f = 0; f < nf; ++f)
      for (Eigen::Index c = 0; c < axes; ++c)
        out[(i * axes + c) * nf * axes + f * axes + c] = static_cast<float>(path(f, i));
  return parameters;
}

}  // namespace nlo::trainer
