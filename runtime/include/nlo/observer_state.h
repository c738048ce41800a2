// SPDX-License-Identifier: MIT
// All of an observer that changes, and which of its values stepping can reach. A state may come back from storage,
// damaged: what is not reachable is refused.
#pragma once

#include <cstdint>

#include "nlo/measurement.h"
#include "nlo/vector.h"

namespace nlo {

template <class Scalar, int kNy, int kNz, int kNu>
struct ObserverState {
  Scalar z[kNz];
  Scalar y[kNy];                                         ///< last good output
  [[no_unique_address]] InputMemory<Scalar, kNu> input;  ///< last good input
  std::uint16_t held;                                    ///< measurements held in a row
  StepStatus status;
  std::uint8_t started;  ///< 1 once a first measurement has come; no bool: storage may hand back any byte
};

/// z is finite, and not so large that a step overflows.
template <class Scalar, int kNz>
constexpr bool is_reachable(const Scalar (&z)[kNz]) {
  constexpr Scalar kLargest = Scalar(0x1p100);
  bool good = true;
  for (const Scalar value : z) good = good && is_finite(value) && value >= -kLargest && value <= kLargest;
  return good;
}

/// The same of a whole state: z and inputs finite, y in its range (0 before the first measurement), flags valid.
template <class Scalar, int kNy, int kNz, int kNu>
constexpr bool is_reachable(const ObserverState<Scalar, kNy, kNz, kNu>& state,
                            const OutputRange<Scalar, kNy>& outputs) {
  if (!is_reachable(state.z) || state.started > 1 || state.status > StepStatus::kDiverged) return false;
  if constexpr (kNu > 0) {
    for (const Scalar u : state.input.u) {
      if (!is_finite(u)) return false;
    }
  }
  if (state.started == 1) return outputs.may_hold(state.y);
  for (const Scalar y : state.y) {
    if (!(y == Scalar(0))) return false;
  }
  return true;
}

}  // namespace nlo
