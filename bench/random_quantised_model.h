// SPDX-License-Identifier: MIT
// The models of random_model.h in int16: the same weights, rounded.
#pragma once

#include <nlo/quantised_map.h>
#include <nlo/quantised_units.h>

#include <cstdint>
#include <utility>

#include "bench/random_model.h"
#include "bench/random_structures.h"

namespace nlo::bench {

/// Returns random_dense() with weights times 2^kScale, inputs in Q15, and sums shifted down to Q16. The scales below
/// are the largest for which no sum of these sizes can overflow: sum |w| 2^kScale < 2^16.
template <int kIn, int kOut, int kScale>
constexpr auto random_quantised_dense(std::uint32_t seed) {
  const auto nearest = [](float value) { return static_cast<std::int32_t>(value < 0 ? value - 0.5F : value + 0.5F); };
  const Dense<float, kIn, kOut> dense = random_dense<kIn, kOut>(seed);
  QuantisedDense<kIn, kOut, kScale + 15 - 16> layer{};
  for (int o = 0; o < kOut; ++o) {
    for (int i = 0; i < kIn; ++i) {
      layer.weights[o][i] = static_cast<std::int16_t>(nearest(dense.weights[o][i] * static_cast<float>(1 << kScale)));
    }
    layer.bias[o] = nearest(dense.bias[o] * static_cast<float>(1 << (kScale + 15)));
  }
  return layer;
}

/// Returns a network kIn-kWidth x kDepth-kOut with inputs in +-5.
template <Activation kKind, int kWidth, int kDepth, int kIn = 3, int kOut = 2>
constexpr auto random_quantised_map() {
  constexpr int kScale = kWidth <= 16 ? 13 : 12;
  auto mlp = [] {
    if constexpr (kDepth == 0) {
      return make_quantised_mlp<kKind>(random_quantised_dense<kIn, kOut, kScale>(1000));
    } else {
      return []<std::size_t... kIndex>(std::index_sequence<kIndex...>) {
        return make_quantised_mlp<kKind>(random_quantised_dense < kIn, kWidth, kIn <= 3 ? 14 : kScale > (1),
                                         random_quantised_dense<kWidth, kWidth, kScale>(kIndex + 2)...,
                                         random_quantised_dense<kWidth, kOut, kScale>(1000));
      }
      (std::make_index_sequence<kDepth - 1>{});
    }
  }();
  QuantisedMap<decltype(mlp)> map{};
  for (float& gain : map.gain) gain = 32767.0F / 5.0F;
  map.mlp = mlp;
  for (float& scale : map.scale) scale = 1.0F / static_cast<float>(1 << (kScale + 15));
  return map;
}

/// Returns random_kkl_model() with this network.
template <Activation kKind, int kWidth, int kDepth>
constexpr auto random_quantised_model() {
  const auto single = random_kkl_model<kKind, 1, 1>();
  constexpr auto kMap = random_quantised_map<kKind, kWidth, kDepth>();
  return KklModel<float, 2, 1, 3, 1, std::remove_const_t<decltype(kMap)>>{
      single.sample_period_s, single.stale_after, single.latent, single.outputs, single.domain, kMap};
}

/// Returns random_gated_model() in int16.
template <int kUnits, int kDepth = 1, int kNy = 1, int kNx = 2>
constexpr auto random_quantised_gated_model() {
  constexpr int kIn = kUnits + kNy;
  constexpr auto kGates = make_quantised_mlp<Activation::kTanh>(random_quantised_dense<kIn, 2 * kUnits, 12>(1));
  constexpr auto kCandidate = make_quantised_mlp<Activation::kTanh>(random_quantised_dense<kIn, kUnits, 12>(2));
  constexpr auto kMap = random_quantised_map<Activation::kTanh, kUnits, kDepth, kUnits, kNx>();
  GatedModel<float, kNx, kNy, kUnits, QuantisedUnits<std::remove_const_t<decltype(kGates)>, kNy>,
             QuantisedUnits<std::remove_const_t<decltype(kCandidate)>>, std::remove_const_t<decltype(kMap)>>
      model{};
  set_sampling(model);
  for (float& gain : model.gates.gain) gain = 32767.0F / 10.0F;
  model.gates.mlp = kGates;
  model.candidate.mlp = kCandidate;
  model.inverse_map = kMap;
  return model;
}

}  // namespace nlo::bench
