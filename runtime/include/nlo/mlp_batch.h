// SPDX-License-Identifier: MIT
// Evaluates a learned map for kPlants inputs at once: in [kIn][kPlants], out [kOut][kPlants].
// kernels::for_batch_block() chooses a kPlants that suits the CPU.
#pragma once

#include "nlo/kernels/activation.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/batch.h"
#include "nlo/kernels/simd.h"
#include "nlo/mlp.h"

namespace nlo::inline NLO_ISA {

template <Arithmetic kArithmetic, int kPlants, Activation kKind, class... Layers>
void evaluate_batch(const Mlp<kKind, Layers...>& mlp, const typename Mlp<kKind, Layers...>::Scalar* in,
                    typename Mlp<kKind, Layers...>::Scalar* out) {
  using Net = Mlp<kKind, Layers...>;
  LayerBuffer<typename Net::Scalar, Net::kWidest * kPlants> ping, pong;
  kernels::evaluate_batch<kKind, kArithmetic, kPlants>(mlp, in, out, ping.values, pong.values);
}

template <Arithmetic kArithmetic, int kPlants, class Net, class LinearPath, class ErrorHead, class Products,
          class Fallback>
void evaluate_batch(const LearnedMap<Net, LinearPath, ErrorHead, Products, Fallback>& map,
                    const typename Net::Scalar* in, typename Net::Scalar* out) {
  using Map = LearnedMap<Net, LinearPath, ErrorHead, Products, Fallback>;
  LayerBuffer<typename Net::Scalar, Map::kHasClockProducts ? Net::kIn * kPlants : 1> all;
  if constexpr (Map::kHasClockProducts) {
    map.products.template append<Map::kIn, kPlants>(in, all.values);
    in = all.values;
  }
  evaluate_batch<kArithmetic, kPlants>(map.mlp, in, out);
  if constexpr (Map::kHasLinearPath) {
    for (int o = 0; o < Net::kOut; ++o) {
      for (int i = 0; i < Net::kIn; ++i) {
        for (int n = 0; n < kPlants; ++n) {
          typename Net::Scalar& total = out[o * kPlants + n];
          total = multiply_add<kArithmetic>(map.linear_path.weights[o][i], in[i * kPlants + n], total);
        }
      }
    }
  }
  if constexpr (Map::kHasFallback) map.fallback.template correct<kArithmetic, kPlants>(in, out);
}

}  // namespace nlo::inline NLO_ISA
