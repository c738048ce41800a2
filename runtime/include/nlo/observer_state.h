// SPDX-License-Identifier: MIT
// All of an observer that changes, and which of its values stepping can reach. A state may come back from storage,
// damaged: what is not reachable is refused.
#pragma once

#include <cstdint>

#include "nlo/acting_inputs.h"
#include "nlo/measurement.h"
#include "nlo/vector.h"

namespace nlo {

template <class Scalar, int kNy, int kNz, int kNu>
struct ObserverState {
  Scalar z[kNz];
  Scalar y[kNy];                                         ///< last good output
  [[no_unique_address]] InputMemory<Scalar, kNu> input;  ///< last good input
  ChannelHealth health[kNy + kNu];                       ///< of each output, then of each input
  StepStatus status;
  std::uint8_t started;  ///< 1 once a first measurement has come; no bool: storage may hand back any byte
};

/// As before the first measurement, z = initial. Member by member, which takes less code than a copy of State{}.
template <class Scalar, int kNy, int kNz, int kNu, class Initial>
constexpr void restart(ObserverState<Scalar, kNy, kNz, kNu>& state, const Initial& initial) {
  for (int r = 0; r < kNz; ++r) state.z[r] = initial[r];
  for (int j = 0; j < kNy; ++j) state.y[j] = Scalar(0);
  state.input = {};
  for (ChannelHealth& health : state.health) health = 0;
  state.started = 0;
  state.status = StepStatus::kOk;
}

/// z is finite, and not so large that a step overflows.
template <class Scalar, int kNz>
constexpr bool is_reachable(const Scalar (&z)[kNz]) {
  return all_below(z, Scalar(0x1p100));
}

/// The same of a whole state: z and inputs finite, y in its range (0 before the first measurement), flags valid.
template <class Scalar, int kNy, int kNz, int kNu>
constexpr bool is_reachable(const ObserverState<Scalar, kNy, kNz, kNu>& state,
                            const ReadingRange<Scalar, kNy>& outputs) {
  if (!is_reachable(state.z) || state.started > 1 || state.status > StepStatus::kReset) return false;
  if (!state.input.is_reachable()) return false;
  if (state.started == 1) return outputs.may_hold(state.y);
  for (const Scalar y : state.y) {
    if (!(y == Scalar(0))) return false;
  }
  return true;
}

/// Is this latent state inside what training has seen? A learned T* says nothing outside.
/// The box that the latent states of the training set filled, per coordinate. For angle outputs, and others
/// that T* knows only through z - S y, the latent is taken relative to its steady state S y, which does not change when
/// the angle turns or the output rests elsewhere.
template <class Scalar, int kNz>
struct Domain {
  Scalar latent_min[kNz];
  Scalar latent_max[kNz];

  constexpr bool contains(const Scalar (&z)[kNz]) const {
    // No && and no bool: as many instructions wherever z is, and vectors of them where there are any.
    int inside = 1;
    for (int r = 0; r < kNz; ++r) {
      inside &= static_cast<int>(z[r] >= latent_min[r]) & static_cast<int>(z[r] <= latent_max[r]);
    }
    return inside != 0;
  }
};

}  // namespace nlo
