// SPDX-License-Identifier: MIT
// The observers of random_model.h and random_structures.h with an error head on T*, for the cost of
// estimate_with_error().
#pragma once

#include <nlo/error_head.h>

#include <type_traits>

#include "bench/random_structures.h"

namespace nlo::bench {

template <class Map>
using SureMap = LearnedMap<decltype(Map::mlp), NoLinearPath, ErrorHead<float, decltype(Map::mlp)::kHidden, 2>>;

/// Returns `map` with a random head, whose sigma stays between 1/16 and 4.
template <class Map>
constexpr SureMap<Map> with_error_head(const Map& map) {
  SureMap<Map> sure{};
  sure.mlp = map.mlp;
  sure.error.layer = pack(random_dense<2 * decltype(Map::mlp)::kHidden, 2>(7));
  for (int i = 0; i < 2; ++i) {
    sure.error.lowest[i] = -4.0F;
    sure.error.highest[i] = 2.0F;
    sure.error.bound_95[i] = 2.0F;
  }
  return sure;
}

template <Activation kKind, int kWidth, int kDepth>
constexpr auto random_sure_kkl_model() {
  constexpr auto kPlain = random_kkl_model<kKind, kWidth, kDepth>();
  KklModel<float, 2, 1, 3, 1, SureMap<std::remove_cvref_t<decltype(kPlain.inverse_map)>>> model{};
  model.sample_period_s = kPlain.sample_period_s;
  model.stale_after = kPlain.stale_after;
  model.latent = kPlain.latent;
  model.outputs = kPlain.outputs;
  model.domain = kPlain.domain;
  model.inverse_map = with_error_head(kPlain.inverse_map);
  return model;
}

template <int kUnits>
constexpr auto random_sure_gated_model() {
  constexpr auto kPlain = random_gated_model<kUnits>();
  GatedModel<float, 2, 1, kUnits, std::remove_cvref_t<decltype(kPlain.gates)>,
             std::remove_cvref_t<decltype(kPlain.candidate)>,
             SureMap<std::remove_cvref_t<decltype(kPlain.inverse_map)>>>
      model{};
  set_sampling(model);
  model.gates = kPlain.gates;
  model.candidate = kPlain.candidate;
  model.inverse_map = with_error_head(kPlain.inverse_map);
  return model;
}

}  // namespace nlo::bench
