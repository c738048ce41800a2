// SPDX-License-Identifier: MIT
// Observers of the other structures with random weights, as constants: see random_model.h.
#pragma once

#include <nlo/carried_observer.h>
#include <nlo/driven_kkl_observer.h>
#include <nlo/gated_observer.h>
#include <nlo/general_observer.h>
#include <nlo/luenberger_observer.h>
#include <nlo/prior_observer.h>

#include "bench/random_model.h"

namespace nlo::bench {

/// Sets outputs in +-10, a domain of +-5, 50 Hz, and ramps between samples.
template <class Model>
constexpr void set_sampling(Model& model) {
  model.sample_period_s = 0.02F;
  model.stale_after = 10;
  for (int j = 0; j < Model::kNy; ++j) {
    model.outputs.min[j] = -10.0F;
    model.outputs.max[j] = 10.0F;
  }
  for (int r = 0; r < Model::kNz; ++r) {
    model.domain.latent_min[r] = -5.0F;
    model.domain.latent_max[r] = 5.0F;
  }
}

/// Returns observer (15) for two states: A - G C = [[-3, 1], [-6, -0.3]], g_hat with kDepth hidden layers of kWidth.
template <Activation kKind, int kWidth, int kDepth>
constexpr auto random_luenberger_model() {
  using Network = decltype(random_mlp<kKind, 2, kWidth, kDepth, 2>());
  LuenbergerModel<float, 2, 1, LearnedMap<Network>> model{};
  set_sampling(model);
  model.hold = Hold::kFirstOrder;
  model.error_matrix[0][0] = -3.0F;
  model.error_matrix[0][1] = 1.0F;
  model.error_matrix[1][0] = -6.0F;
  model.error_matrix[1][1] = -0.3F;
  model.gain[0][0] = 3.0F;
  model.gain[1][0] = 2.0F;
  model.nonlinearity.mlp = random_mlp<kKind, 2, kWidth, kDepth, 2>();
  return model;
}

/// Observer (11) for two states and n_z = 3: F = -3 z + 2 y plus a network; G is a network or the given map.
template <Activation kKind, int kWidth, int kDepth, class Map = RandomMap<kKind, 3, kWidth, kDepth, 2>>
constexpr auto random_general_model(const Map& inverse_map = {random_mlp<kKind, 3, kWidth, kDepth, 2>()}) {
  using Dynamics = decltype(random_mlp<kKind, 4, kWidth, kDepth, 3>());
  GeneralModel<float, 2, 1, 3, LearnedMap<Dynamics, LinearPath<float, 4, 3>>, Map> model{};
  set_sampling(model);
  model.hold = Hold::kFirstOrder;
  model.dynamics.mlp = random_mlp<kKind, 4, kWidth, kDepth, 3>();
  for (int r = 0; r < 3; ++r) {
    model.dynamics.linear_path.weights[r][r] = -3.0F;
    model.dynamics.linear_path.weights[r][3] = 2.0F;
  }
  model.inverse_map = inverse_map;
  return model;
}

/// kUnits gated units that read kNy outputs. T* reads z and has kDepth hidden layers of kUnits. <64, 0, 32, 32> has the
/// products of EdgeMark's GRU of 20,896 parameters: 64 units, 32 inputs, and a layer of 32 outputs.
template <int kUnits, int kDepth = 1, int kNy = 1, int kNx = 2>
constexpr auto random_gated_model() {
  constexpr Activation kKind = Activation::kTanh;
  constexpr int kIn = kUnits + kNy;
  using Gates = decltype(make_mlp<kKind>(random_dense<kIn, 2 * kUnits>(1)));
  using Candidate = decltype(make_mlp<kKind>(random_dense<kIn, kUnits>(2)));
  using Network = decltype(random_mlp<kKind, kUnits, kUnits, kDepth, kNx>());
  GatedModel<float, kNx, kNy, kUnits, LearnedMap<Gates>, LearnedMap<Candidate>, LearnedMap<Network>> model{};
  set_sampling(model);
  model.gates.mlp = make_mlp<kKind>(random_dense<kIn, 2 * kUnits>(1));
  model.candidate.mlp = make_mlp<kKind>(random_dense<kIn, kUnits>(2));
  model.inverse_map.mlp = random_mlp<kKind, kUnits, kUnits, kDepth, kNx>();
  return model;
}

/// A pendulum with friction, y = angle.
struct PendulumEquations {
  static constexpr void derivative(const float (&x)[5], const float*, float (&dx)[5]) {
    const auto circle0 = circle(x[0]);
    const float falls = rounded<float>(-9.81F * circle0.cosine);
    dx[0] = x[1];
    dx[1] = rounded<float>(-9.81F * circle0.sine) - rounded<float>(0.1F * x[1]);
    dx[2] = rounded<float>(2.0F * x[3]);
    dx[3] = x[4] + (rounded<float>(falls * x[2]) - rounded<float>(0.1F * x[3]));
    dx[4] = 2.0F * (rounded<float>(falls * x[3]) - rounded<float>(0.1F * x[4]));
  }
  static constexpr void output(const float* x, float (&y)[3]) {
    y[0] = x[0];
    y[1] = 1.0F;
    y[2] = 0.0F;
  }
};

/// Returns a prior observer with these equations and kUnits units; T* has one hidden layer of 16.
template <int kUnits>
constexpr auto random_prior_model() {
  constexpr Activation kKind = Activation::kTanh;
  constexpr int kIn = kUnits + 5;  // plus the innovation at two scales, y, and two states
  using Gates = decltype(make_mlp<kKind>(random_dense<kIn, 2 * kUnits>(1)));
  using Candidate = decltype(make_mlp<kKind>(random_dense<kIn, kUnits>(2)));
  using Correction = decltype(make_mlp<kKind>(random_dense<kIn, 7>(3)));
  using Network = decltype(random_mlp<kKind, kUnits + 5, 16, 1, 2>());
  PriorModel<float, 2, 1, kUnits, PendulumEquations, LearnedMap<Gates>, LearnedMap<Candidate>, LearnedMap<Correction>,
             LearnedMap<Network>>
      model{};
  set_sampling(model);
  for (int i = 0; i < 5; ++i) {
    model.state_min[i] = i == 2 || i == 4 ? 1e-6F : -5.0F;
    model.state_max[i] = 5.0F;
  }
  model.initial[kUnits + 2] = model.initial[kUnits + 4] = 1.0F;
  model.state_noise[0] = model.state_noise[1] = 1e-3F;
  model.output_noise[0] = 0.1F;
  model.fine[0] = 0.05F;
  model.coarse[0] = 3.0F;
  model.gates.mlp = make_mlp<kKind>(random_dense<kIn, 2 * kUnits>(1));
  model.candidate.mlp = make_mlp<kKind>(random_dense<kIn, kUnits>(2));
  model.correction.mlp = make_mlp<kKind>(random_dense<kIn, 7>(3));
  model.inverse_map.mlp = random_mlp<kKind, kUnits + 5, 16, 1, 2>();
  return model;
}

/// Returns a model of three vectors that a gyroscope rotates, from one accelerometer. The estimate is a direction.
constexpr auto random_carried_model() {
  CarriedModel<float, 3, 3, 3, 0, false, true> model{};
  set_sampling(model);
  for (int r = 0; r < 6; ++r) {
    model.outputs.min[r] = -10.0F;
    model.outputs.max[r] = 10.0F;
  }
  model.latent.hold = Hold::kFirstOrder;
  for (int r = 0; r < 3; ++r) {
    model.latent.eigenvalues[r] = -0.6F / static_cast<float>(1 << r);
    model.latent.output_injection[r][0] = 1.0F;
    model.weights[0][r] = 0.5F + static_cast<float>(r);
  }
  model.latent.step =
      discretise<0>(model.latent.hold, model.latent.eigenvalues, model.latent.output_injection, model.sample_period_s);
  return model;
}

/// Observer (24)-(25): random_kkl_model with one input that acts on both states, on the second in proportion to the
/// first.
template <Activation kKind, int kWidth, int kDepth>
constexpr auto random_driven_model(Hold input_hold = Hold::kZeroOrder) {
  using Network = decltype(random_mlp<kKind, 3, kWidth, kDepth, 2>());
  using Forward = decltype(random_mlp<kKind, 2, kWidth, kDepth, 3>());
  DrivenKklModel<float, 2, 1, 3, 1, 1, LearnedMap<Network>, LearnedMap<Forward>> model{};
  const auto plain = random_kkl_model<kKind, kWidth, kDepth>();
  set_sampling(model);
  model.input_hold = input_hold;
  model.latent = plain.latent;
  model.forced =
      forced_step<1>(Hold::kFirstOrder, model.latent.eigenvalues, model.latent.output_injection, model.sample_period_s);
  model.input_field.constant[0][0] = 0.5F;
  model.input_field.constant[0][1] = 1.0F;
  model.input_field.linear[0][1][0] = 0.25F;
  model.inverse_map = plain.inverse_map;
  model.forward_map.mlp = random_mlp<kKind, 2, kWidth, kDepth, 3>();
  return model;
}

}  // namespace nlo::bench
