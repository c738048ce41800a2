// SPDX-License-Identifier: MIT
// An objective with the objects that it refers to, and the variants of experiments for its tests.
#pragma once

#include <functional>
#include <random>
#include <vector>

#include "tests/support/mirrored.h"
#include "tests/training/training_testing.h"
#include "trainer/learn/losses/loss_registry.h"
#include "trainer/learn/training/objective.h"
#include "trainer/structures/kkl_family.h"

namespace nlo::trainer::testing {

// Segments of unequal lengths, in two groups of eight lanes, of which the second is not full.
inline const std::vector<int> kUnequal = {40, 25, 60, 33, 40, 12, 51, 40, 28, 60, 7};

/// An objective with the objects that it refers to, normalised, at its initial parameters plus random numbers.
struct Problem {
  Experiment experiment;
  Dataset dataset;
  TrainingData data;
  ObserverStructure structure;
  ThreadPool pool{1};
  Objective objective;
  std::vector<float> parameters;

  Problem(const Experiment& e, const Dataset& d)
      : experiment(e),
        dataset(e.training.mirror ? mirrored(d) : d),
        data(dataset),
        structure(make_structure(experiment, needs_forward_map(experiment.loss), dataset.outputs, dataset.states)),
        objective(experiment, structure, data, pool) {
    normalise_dynamics(structure, data, pool);
    const Rollout& rollout = objective.roll_out_flight(initial_dynamics(structure, experiment).data());
    normalise(structure, rollout);
    parameters = initial_parameters(structure, experiment, rollout);
    std::mt19937 random(4);
    std::uniform_real_distribution<float> uniform(-0.2F, 0.2F);
    const std::size_t first = static_cast<std::size_t>(structure.latent.learned);
    for (std::size_t i = first; i < parameters.size(); ++i) {
      parameters[i] += uniform(random);  // biases would be zero otherwise
    }
  }
  Problem(const Problem&) = delete;

  /// Uses the scales of `other`: scales depend on the drawn segments, and a comparison needs equal scales.
  void use_scales_of(const Problem& other) {
    structure.features = other.structure.features;
    structure.state_mean = other.structure.state_mean;
    structure.state_scale = other.structure.state_scale;
  }
  double loss(const std::vector<float>& at, long step) { return objective.evaluate(at.data(), step, nullptr).loss; }
  std::vector<float> gradient(long step) {
    std::vector<float> out(parameters.size());
    objective.evaluate(parameters.data(), step, out.data());
    return out;
  }
};

inline constexpr long kSomeStep = 5;

struct Variant {
  const char* name;
  std::function<void(Experiment&)> change;
};

inline const std::vector<Variant>& variants() {
  static const std::vector<Variant> all = {
      {"plain", [](Experiment&) {}},
      {"full_batch", [](Experiment& e) { e.training.mode = TrainingMode::kFullBatch; }},
      {"gaussian_noise",
       [](Experiment& e) {
         e.training.noise = {NoiseKind::kGaussian, 0.3};
       }},
      {"uniform_noise",
       [](Experiment& e) {
         e.training.noise = {NoiseKind::kUniform, 0.5};
       }},
      {"noise_levels",
       [](Experiment& e) {
         e.training.noise = {NoiseKind::kGaussian, 0.3};
         e.training.noise_level_max = 2.0;
       }},
      {"mirror", [](Experiment& e) { e.training.mirror = true; }},
      {"normalised_loss", [](Experiment& e) { e.loss.scale = ErrorScale::kNormalised; }},
      {"eigenvalue_penalty", [](Experiment& e) { e.loss.weights["eigenvalue_penalty"] = 0.05; }},
      {"segments", [](Experiment& e) { e.training.segment_s = 1.0; }},
      {"integral",
       [](Experiment& e) {
         e.loss.reduction = Reduction::kIntegral;
         e.loss.weights["eigenvalue_penalty"] = 0.01;
       }},
      {"logarithm",
       [](Experiment& e) {
         e.loss.reduction = Reduction::kLogarithm;
         e.loss.weights["terminal"] = 0.3;
         e.loss.weights["state_error"] = 0.5;
       }},
      {"terminal_beside_running",
       [](Experiment& e) {
         e.loss.weights["terminal"] = 0.8;
         e.loss.weights["state_error"] = 0.5;
       }},
      {"terminal_alone",
       [](Experiment& e) {
         e.loss.weights["terminal"] = 1.0;
         e.loss.weights["state_error"] = 0.0;
         e.training.segment_s = 1.0;
       }},
      {"maps_jointly",
       [](Experiment& e) {
         e.loss.weights["map_consistency"] = 1.0;
         e.loss.weights["reconstruction"] = 1.0;
         e.loss.weights["state_error"] = 0.0;
         e.forward_map.hidden = {4};
       }},
      {"maps_apart_mirrored",
       [](Experiment& e) {
         e.loss.weights["map_consistency"] = 0.5;
         e.loss.scale = ErrorScale::kNormalised;
         e.forward_map.hidden = {4};
         e.training.mirror = true;
       }},
      {"backprop",
       [](Experiment& e) {
         e.training.gradient = LatentGradient::kBackprop;
         e.observer.hold = Hold::kRk4;
       }},
      {"adjoint",
       [](Experiment& e) {
         e.training.gradient = LatentGradient::kAdjoint;
         e.observer.hold = Hold::kRk4;
       }},
      {"general",
       [](Experiment& e) {
         e.observer.structure = "general";
         e.dynamics.hidden = {5};
       }},
      {"luenberger_by_adjoint",
       [](Experiment& e) {
         make_luenberger(e);
         e.training.gradient = LatentGradient::kAdjoint;
         e.training.noise = {NoiseKind::kGaussian, 0.3};
       }},
      {"luenberger_integral",
       [](Experiment& e) {
         make_luenberger(e);
         e.loss.reduction = Reduction::kIntegral;
         e.loss.weights["terminal"] = 0.5;
       }},
      {"early_samples",
       [](Experiment& e) {
         e.training.early_s = 0.3;
         e.training.early_share = 0.5;
       }},
      {"ticks_drawn_many_times", [](Experiment& e) { e.training.samples_per_step = 5000; }},
      {"linear_path", [](Experiment& e) { e.inverse_map.linear_path = true; }},
      {"linear_path_alone",
       [](Experiment& e) {
         e.inverse_map.hidden = {};
         e.inverse_map.linear_path = true;
       }},
      {"silu", [](Experiment& e) { e.inverse_map.activation = "silu"; }},
      {"steady_start_unit_gain_reading_output",
       [](Experiment& e) {
         e.observer.start = LatentStart::kSteady;
         e.observer.output_injection = Injection::kUnitGain;
         e.observer.features = FeatureSet::kLatentAndOutput;
       }},
      {"reading_latent_minus_output_and_a_clock",
       [](Experiment& e) {
         e.observer.output_injection = Injection::kUnitGain;
         e.observer.features = FeatureSet::kLatentMinusOutput;
         e.observer.clocks_s = {0.5};
       }},
      {"reading_products_with_two_clocks",
       [](Experiment& e) {
         e.observer.output_injection = Injection::kUnitGain;
         e.observer.features = FeatureSet::kLatentMinusOutput;
         e.observer.clocks_s = {0.2, 0.5};
         e.observer.own.set<KklConfig>().clock_products = ClockProductSet::kAll;
       }},
      {"zero_order_hold", [](Experiment& e) { e.observer.hold = Hold::kZeroOrder; }},
      {"rk4", [](Experiment& e) { e.observer.hold = Hold::kRk4; }}};
  return all;
}

inline Dataset masked(Dataset data) {
  for (Trajectory& run : data.trajectories) {
    for (Eigen::Index k = 0; k < run.samples(); k += 3) run.weight(k) = 0.0;
    for (Eigen::Index k = 1; k < run.samples(); k += 5) run.weight(k) = 0.25;
  }
  return data;
}

}  // namespace nlo::trainer::testing
