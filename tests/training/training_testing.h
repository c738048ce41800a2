// SPDX-License-Identifier: MIT
// Small data sets and experiments for the tests of training, and a reference run of a trained model in double.
#pragma once

#include <cmath>
#include <random>
#include <string>

#include "codegen/model/model.h"
#include "codegen/replay/reference_observer.h"
#include "tests/nn/plain_network.h"
#include "tests/sensitivity/plain_latent.h"
#include "tests/support/scratch_directory.h"
#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/structures/observer_gain.h"

namespace nlo::trainer::testing {

/// Returns runs of two states and one output made of random harmonics: smooth, but of no plant. Long runs have larger
/// values than short ones.
inline Dataset harmonics(const std::vector<int>& samples, bool jittered, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Dataset data;
  data.outputs = {{"y", "m", 0.0}};
  data.states = {{"position", "m", 0.0}, {"velocity", "m/s", 0.0}};
  data.sample_period_s = 0.05;
  data.uniform = !jittered;
  for (std::size_t r = 0; r < samples.size(); ++r) {
    const int n = samples[r];
    Trajectory run;
    run.source = "simulation " + std::to_string(r);
    run.time_s.resize(n);
    run.outputs.resize(1, n);
    run.states.resize(2, n);
    run.weight = Eigen::VectorXd::Ones(n);
    const double amplitude = 0.5 + 0.02 * n;
    const double phase = 3.0 * uniform(random);
    const double offset = 0.3 * uniform(random);
    double time_s = 0.0;
    for (int k = 0; k < n; ++k) {
      run.time_s(k) = time_s;
      run.states(0, k) = offset + amplitude * std::sin(2.0 * time_s + phase);
      run.states(1, k) = 2.0 * amplitude * std::cos(2.0 * time_s + phase) + 0.2 * std::cos(7.0 * time_s);
      run.outputs(0, k) = run.states(0, k);
      time_s += data.sample_period_s * (jittered ? 1.0 + 0.4 * uniform(random) : 1.0);
    }
    data.trajectories.push_back(run);
  }
  return data;
}

/// A small experiment that runs quickly and has every part of an observer.
inline Experiment small_experiment() {
  Experiment experiment;
  experiment.name = "small";
  experiment.seed = 3;
  experiment.threads = 1;
  experiment.observer.eigenvalues = {-1.0, -4.0};
  experiment.observer.pairs = {{-2.0, 3.0}};
  experiment.inverse_map.hidden = {5, 4};
  experiment.inverse_map.readout = ReadoutChoice::kNetwork;  // most tests are about the network
  experiment.training.steps = 30;
  experiment.training.learning_rate = 0.01;
  experiment.training.trajectories_per_step = 10;
  experiment.training.samples_per_step = 200;
  experiment.training.validate_every = 7;
  experiment.source_text = "small";
  return experiment;
}

/// Changes an experiment with two states and one output into one with a Luenberger-like observer.
inline void make_luenberger(Experiment& e) {
  e.observer.structure = "luenberger";
  e.observer.eigenvalues = {};
  e.observer.pairs = {};
  e.observer.own.set<LuenbergerConfig>() = {
      .state_matrix = {{0.0, 1.0}, {-1.0, 0.0}}, .output_matrix = {{1.0, 0.0}}, .gain = {{2.0}, {1.5}}};
  e.dynamics.hidden = {5};
}

inline Hold hold_of(const codegen::Model& model) {
  return model.hold;
}

/// z and x_hat at all samples, one column each, computed from the equations in codegen/model/model.h.
struct PlainEstimates {
  Eigen::MatrixXd latent, states;
};
inline PlainEstimates plain_estimates(const codegen::Model& model, const Trajectory& run, bool uniform = true) {
  const Eigen::Index samples = run.samples();
  PlainEstimates result{Eigen::MatrixXd::Zero(model.nz(), samples), Eigen::MatrixXd(model.nx(), samples)};
  std::vector<double> steps_s;
  for (Eigen::Index k = 0; k + 1 < samples; ++k) {
    steps_s.push_back(uniform ? model.sample_period_s : run.time_s(k + 1) - run.time_s(k));
  }
  for (Eigen::Index row = 0; row < model.nz(); row += row < 2 * codegen::linear_latent(model)->pairs ? 2 : 1) {
    const bool pair = row < 2 * codegen::linear_latent(model)->pairs;
    const Cd lambda{codegen::linear_latent(model)->eigenvalues(row),
                    pair ? codegen::linear_latent(model)->eigenvalues(row + 1) : 0.0};
    for (Eigen::Index j = 0; j < model.ny(); ++j) {
      const Cd f{codegen::linear_latent(model)->output_injection(row, j),
                 pair ? codegen::linear_latent(model)->output_injection(row + 1, j) : 0.0};
      const std::vector<double> y(run.outputs.row(j).begin(), run.outputs.row(j).end());
      const std::vector<Cd> z =
          plain_filter(hold_of(model), lambda, f, codegen::linear_latent(model)->starts_steady, y, steps_s);
      for (Eigen::Index k = 0; k < samples; ++k) {
        result.latent(row, k) += z[static_cast<std::size_t>(k)].real();
        if (pair) result.latent(row + 1, k) += z[static_cast<std::size_t>(k)].imag();
      }
    }
    Cd initial{model.initial_latent(row), pair ? model.initial_latent(row + 1) : 0.0};
    for (Eigen::Index k = 0; k < samples; ++k) {
      result.latent(row, k) += initial.real();
      if (pair) result.latent(row + 1, k) += initial.imag();
      if (k + 1 < samples) initial *= plain_step(hold_of(model), lambda, steps_s[static_cast<std::size_t>(k)]).a;
    }
  }
  for (Eigen::Index k = 0; k < samples; ++k) {
    Eigen::VectorXd zy(model.nz() + model.ny());
    zy << result.latent.col(k), run.outputs.col(k);
    const codegen::Network& map = *codegen::inverse_map(model);
    Eigen::VectorXd u = (map.features * zy - map.feature_mean).cwiseQuotient(map.feature_scale);
    for (Eigen::Index f = 0; f < u.size(); ++f)
      if (const int clock = codegen::clock_of(map, f); clock >= 0) u(f) *= zy(clock);
    Eigen::VectorXd a = u;
    for (std::size_t l = 0; l < map.layers.size(); ++l) {
      a = map.layers[l].weights * a + map.layers[l].bias;
      if (l + 1 == map.layers.size()) break;
      for (double& v : a) v = plain_activation(map.activation, v);
    }
    if (map.skip.size() > 0) a += map.skip * u;
    result.states.col(k) = map.output_mean + map.output_scale.cwiseProduct(a);
  }
  return result;
}

/// Returns the weighted root mean square of |x - x_hat| over a data set, from plain_estimates().
inline double plain_rmse(const codegen::Model& model, const Dataset& data) {
  double squares = 0.0;
  double total = 0.0;
  for (const Trajectory& run : data.trajectories) {
    const Eigen::MatrixXd error = plain_estimates(model, run, data.uniform).states - run.states;
    squares += error.colwise().squaredNorm().dot(run.weight);
    total += run.weight.sum();
  }
  return std::sqrt(squares / total);
}

/// Returns the RMSE of the reference observer, with the inputs that its model reads.
inline double reference_rmse(const codegen::Model& model, const Dataset& data) {
  codegen::ReferenceObserver<double> observer(model);
  double squares = 0.0;
  double total = 0.0;
  for (const Trajectory& run : data.trajectories) {
    const Eigen::MatrixXd inputs = model.nu() > 0 ? run.inputs : Eigen::MatrixXd();
    const Eigen::MatrixXd error = observer.run(run.outputs, inputs, run.time_s, data.uniform).x_hat - run.states;
    squares += error.colwise().squaredNorm().dot(run.weight);
    total += run.weight.sum();
  }
  return std::sqrt(squares / total);
}

/// Returns the RMSE over the last samples of each run.
inline double settled_rmse(const codegen::Model& model, Dataset data, Eigen::Index samples) {
  for (Trajectory& run : data.trajectories) run.weight.head(run.samples() - samples).setZero();
  return reference_rmse(model, data);
}

}  // namespace nlo::trainer::testing
