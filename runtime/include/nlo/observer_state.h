// SPDX-License-Identifier: MIT
// The state of an observer: everything that a step changes. A state that is restored from storage may be damaged;
// is_reachable() tells whether steps can have produced it.
#pragma once

#include <cstdint>

#include "nlo/acting_inputs.h"
#include "nlo/measurement.h"
#include "nlo/vector.h"

namespace nlo::inline NLO_ISA {

template <class Scalar, int kNy, int kNz, int kNu>
struct ObserverState {
  Scalar z[kNz];
  Scalar y[kNy];                                         ///< last good readings
  [[no_unique_address]] InputMemory<Scalar, kNu> input;  ///< last good inputs that are no readings
  ChannelHealth health[kNy + kNu];                       ///< health of each reading, then of each such input
  StepStatus status;
  std::uint8_t started;  ///< 1 after the first measurement; not a bool, because storage may return any byte
};

/// Sets the state before the first measurement, z = initial. (A copy of State{} would take more code.)
template <class Scalar, int kNy, int kNz, int kNu, class Initial>
constexpr void restart(ObserverState<Scalar, kNy, kNz, kNu>& state, const Initial& initial) {
  for (int r = 0; r < kNz; ++r) state.z[r] = initial[r];
  for (int j = 0; j < kNy; ++j) state.y[j] = Scalar(0);
  state.input = {};
  for (ChannelHealth& health : state.health) health = 0;
  state.started = 0;
  state.status = StepStatus::kOk;
}

/// Returns true if z is finite and so small that a step cannot overflow.
template <class Scalar, int kNz>
constexpr bool is_reachable(const Scalar (&z)[kNz]) {
  return all_below(z, Scalar(0x1p100));
}

/// Returns true if steps can lead to this state: z and inputs are finite, y is in its range (0 before the first
/// measurement, except for slow outputs, which are kept), and the flags are valid.
template <class Model = void, class Scalar, int kNy, int kNz, int kNu>
constexpr bool is_reachable(const ObserverState<Scalar, kNy, kNz, kNu>& state,
                            const ReadingRange<Scalar, kNy>& outputs) {
  if (!is_reachable(state.z) || state.started > 1 || state.status > StepStatus::kReset) return false;
  if (!state.input.is_reachable()) return false;
  if (state.started == 1) return outputs.may_hold(state.y);
  for (int j = 0; j < kNy; ++j) {
    const bool kept = not_due<Model>(j) > 0 && outputs.may_hold(j, state.y[j]);
    if (!(state.y[j] == Scalar(0)) && !kept) return false;
  }
  return true;
}

/// The domain: the box of the latent states in training, per coordinate. Outside of it the estimates of a learned T*
/// are arbitrary. For outputs that T* reads only through z - S y, such as angles, it is the box of z - S y, which does
/// not change if a constant is added to the output.
template <class Scalar, int kNz>
struct Domain {
  Scalar latent_min[kNz];
  Scalar latent_max[kNz];

  constexpr bool contains(const Scalar (&z)[kNz]) const {
    // & instead of &&: the same number of instructions for every z, and code that compilers can vectorise.
    int inside = 1;
    for (int r = 0; r < kNz; ++r) {
      inside &= static_cast<int>(z[r] >= latent_min[r]) & static_cast<int>(z[r] <= latent_max[r]);
    }
    return inside != 0;
  }
};

}  // namespace nlo::inline NLO_ISA
