// SPDX-License-Identifier: MIT
// Two small types that all other headers use: a fixed-size vector, which may be a constant in flash, and the status of
// a step. Neither allocates, throws or needs start-up code.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "nlo/kernels/arithmetic.h"

namespace nlo {

/// Column vector of kN scalars, an aggregate. nlo/eigen.h gives a view of it as an Eigen vector.
template <class Scalar, int kN>
struct Vector {
  static_assert(kN > 0);
  Scalar values[kN];

  constexpr Scalar& operator[](int i) { return values[i]; }
  constexpr const Scalar& operator[](int i) const { return values[i]; }
  constexpr Scalar* data() { return values; }
  constexpr const Scalar* data() const { return values; }
  constexpr Scalar* begin() { return values; }
  constexpr Scalar* end() { return values + kN; }
  constexpr const Scalar* begin() const { return values; }
  constexpr const Scalar* end() const { return values + kN; }
  static constexpr int size() { return kN; }
};

/// Result of a step; larger is worse. The latent state is finite after every step.
enum class StepStatus : std::uint8_t {
  kOk,          ///< the measurement was used unchanged
  kClamped,     ///< an output or input outside its declared range was clamped to it
  kHeld,        ///< an output was missing, not finite, or an angle out of range: its last good value was used
  kStale,       ///< an output or input was held for about a time constant: do not trust the estimate
  kOutOfRange,  ///< an output or input was outside its declared range for about a time constant: do not trust it either
  kRejected,    ///< the time step was not positive, or longer than the model can span: nothing was done
  kDiverged,    ///< the step would have overflowed: the last z was kept (general, luenberger, driven_kkl)
  kReset,       ///< a bit flip corrupted the state: the observer was reset, the next measurement is its first
};

}  // namespace nlo

namespace nlo::inline NLO_ISA {

/// Returns true if the value is finite. It tests the bits, so that -ffast-math cannot remove the test.
template <class Scalar>
constexpr bool is_finite(Scalar value) {
  static_assert(std::numeric_limits<Scalar>::is_iec559);
  if constexpr (sizeof(Scalar) == 4) {
    return (std::bit_cast<std::uint32_t>(value) & 0x7f800000U) != 0x7f800000U;
  } else {
    return (std::bit_cast<std::uint64_t>(value) & 0x7ff0000000000000U) != 0x7ff0000000000000U;
  }
}

/// Returns |value| < limit by the bits; false if the value is not finite. `limit` is finite and positive.
template <class Scalar>
constexpr bool is_below(Scalar value, Scalar limit) {
  if constexpr (sizeof(Scalar) == 4) {
    return (std::bit_cast<std::uint32_t>(value) & 0x7fffffffU) < std::bit_cast<std::uint32_t>(limit);
  } else {
    return (std::bit_cast<std::uint64_t>(value) & 0x7fffffffffffffffU) < std::bit_cast<std::uint64_t>(limit);
  }
}

/// Returns true if is_below() holds for all values. A value at or above the limit carries into the sign bit of its sum;
/// the carries are collected, so that there is one comparison at the end.
template <class Scalar, int kN>
constexpr bool all_below(const Scalar (&values)[kN], Scalar limit) {
  using Bits = std::conditional_t<sizeof(Scalar) == 4, std::uint32_t, std::uint64_t>;
  constexpr Bits kSign = Bits{1} << (8 * sizeof(Scalar) - 1);
  const Bits rest = kSign - std::bit_cast<Bits>(limit);
  Bits carries = 0;
  for (const Scalar value : values) carries |= (std::bit_cast<Bits>(value) & ~kSign) + rest;
  return (carries & kSign) == 0;
}

}  // namespace nlo::inline NLO_ISA
