// SPDX-License-Identifier: MIT
// Sums the lanes of several registers at once. The input has as many registers as a register has lanes; the result is
// one register with the sum of each. This takes one addition per register. Summing each register separately would take
// one addition per lane.
#pragma once

#include <cstddef>
#include <utility>

#include "nlo/kernels/simd.h"

namespace nlo::trainer {

namespace lane_sums_detail {

/// Returns the lane of [a, b] that goes to `lane` of the result: every second unit of a, then of b, chunk by chunk.
constexpr int source(int lane, int lanes, int chunk, int unit, int odd) {
  const int half = chunk / unit / 2;
  const int place = lane % chunk / unit;
  const int from_b = place >= half ? 1 : 0;
  return from_b * lanes + lane / chunk * chunk + (2 * (place - from_b * half) + odd) * unit + lane % unit;
}

template <int kChunk, int kUnit, int kOdd, class P, std::size_t... kLane>
NLO_INLINE P every_second(P a, P b, std::index_sequence<kLane...>) {
  constexpr int kLanes = sizeof...(kLane);
  return __builtin_shufflevector(a, b, source(static_cast<int>(kLane), kLanes, kChunk, kUnit, kOdd)...);
}

}  // namespace lane_sums_detail

/// Returns a register whose lane i is the sum of the lanes of v[i], in a fixed order. Overwrites `v`.
template <class P, std::size_t kLanes>
NLO_INLINE P lane_sums(P (&v)[kLanes]) {
  if constexpr (kLanes > 1) {
    // Within 128 bits first, then whole 128 bits: x86 shuffles these at once, and the sums end up in order.
    constexpr int kAll = static_cast<int>(kLanes);
    constexpr int kQuad = static_cast<int>(16 / (sizeof(P) / kLanes));
    static_assert(kAll % kQuad == 0);
    const auto halve = [&]<int kChunk, int kUnit>(int count) NLO_INLINE_LAMBDA {
      using lane_sums_detail::every_second;
      constexpr std::make_index_sequence<kLanes> kEach;
      for (int i = 0; i < count / 2; ++i) {
        const P a = v[2 * i], b = v[2 * i + 1];
        v[i] = every_second<kChunk, kUnit, 0>(a, b, kEach) + every_second<kChunk, kUnit, 1>(a, b, kEach);
      }
    };
    int left = kAll;
    for (int width = kQuad; width > 1; width /= 2, left /= 2) halve.template operator()<kQuad, 1>(left);
    for (; left > 1; left /= 2) halve.template operator()<kAll, (kQuad < kAll ? kQuad : 1)>(left);
  }
  return v[0];
}

}  // namespace nlo::trainer
