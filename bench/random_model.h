// SPDX-License-Identifier: MIT
// Observers with random weights, of any size, as constants. The cost of a step does not depend on the learned values.
// They are built like those of a generated header. Benchmarks time them, and the audits of the runtime examine them.
#pragma once

#include <nlo/kkl_observer.h>

#include <cstdint>
#include <utility>

namespace nlo::bench {

/// Numbers uniform in [-1, 1), the same on every platform: the upper bits of a linear congruential generator.
struct RandomUniform {
  std::uint32_t state;

  constexpr float operator()() {
    state = state * 1664525U + 1013904223U;
    return static_cast<float>(static_cast<std::int32_t>(state >> 8) - 0x800000) / 8388608.0F;
  }
};

/// Returns a layer whose weights are uniform in +-sqrt(3 / n_in), so that activations neither vanish nor saturate.
template <int kIn, int kOut, class Weight = float>
constexpr Dense<Weight, kIn, kOut> random_dense(std::uint32_t seed) {
  float scale = 1.0F;  // sqrt(3 / kIn) by Newton's method, because std::sqrt is not constexpr
  for (int i = 0; i < 20; ++i) scale = 0.5F * (scale + 3.0F / static_cast<float>(kIn) / scale);
  RandomUniform random{seed};
  Dense<Weight, kIn, kOut> layer{};
  for (auto& row : layer.weights) {
    for (Weight& weight : row) weight = scale * random();
  }
  for (float& bias : layer.bias) bias = 0.1F * random();
  return layer;
}

/// Returns a network kIn - kWidth x kDepth - kOut.
template <Activation kKind, int kIn, int kWidth, int kDepth, int kOut, class Weight = float>
constexpr auto random_mlp() {
  if constexpr (kDepth == 0) {
    return make_mlp<kKind>(random_dense<kIn, kOut, Weight>(1000));
  } else {
    return []<std::size_t... kIndex>(std::index_sequence<kIndex...>) {
      return make_mlp<kKind>(random_dense<kIn, kWidth, Weight>(1), random_dense<kWidth, kWidth, Weight>(kIndex + 2)...,
                             random_dense<kWidth, kOut, Weight>(1000));
    }
    (std::make_index_sequence<kDepth - 1>{});
  }
}

template <Activation kKind, int kIn, int kWidth, int kDepth, int kOut>
using RandomMap = LearnedMap<decltype(random_mlp<kKind, kIn, kWidth, kDepth, kOut>())>;

/// An observer for two states from one output at 50 Hz, n_z = 3 (a complex pair and a real eigenvalue), with an inverse
/// map of kDepth hidden layers of kWidth. random_kkl_model<kTanh, 50, 4> has the size of the paper's examples.
template <Activation kKind, int kWidth, int kDepth, class Weight = float>
constexpr auto random_kkl_model() {
  using Network = decltype(random_mlp<kKind, 3, kWidth, kDepth, 2, Weight>());
  using Model = KklModel<float, 2, 1, 3, 1, LearnedMap<Network>>;
  Model model{};
  model.sample_period_s = 0.02F;
  model.stale_after = 10;
  constexpr float kRe = -0.8F, kIm = 0.9F, kReal = -2.0F;
  model.latent.hold = Hold::kFirstOrder;
  model.latent.eigenvalues[0] = kRe;
  model.latent.eigenvalues[1] = kIm;
  model.latent.eigenvalues[2] = kReal;
  model.latent.output_injection[0][0] = 1.0F;
  model.latent.output_injection[2][0] = 1.0F;
  model.latent.step =
      discretise<1>(model.latent.hold, model.latent.eigenvalues, model.latent.output_injection, model.sample_period_s);
  model.latent.steady_gain[0][0] = -kRe / (kRe * kRe + kIm * kIm);  // -1 / lambda
  model.latent.steady_gain[1][0] = kIm / (kRe * kRe + kIm * kIm);
  model.latent.steady_gain[2][0] = -1.0F / kReal;
  model.outputs.min[0] = -10.0F;
  model.outputs.max[0] = 10.0F;
  for (int r = 0; r < 3; ++r) {
    model.domain.latent_min[r] = -5.0F;
    model.domain.latent_max[r] = 5.0F;
  }
  model.inverse_map.mlp = random_mlp<kKind, 3, kWidth, kDepth, 2, Weight>();
  return model;
}

}  // namespace nlo::bench
