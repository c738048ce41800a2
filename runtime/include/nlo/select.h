// SPDX-License-Identifier: MIT
// How the two policies choose between two values. The deterministic policy is constant-time: it takes as many
// instructions whatever is measured, and so never branches on data. The fast policy branches: a processor predicts the
// usual side, and the next step need not wait for the comparison.
#pragma once

#include <bit>
#include <cstdint>
#include <type_traits>

#include "nlo/arithmetic.h"
#include "nlo/simd.h"

namespace nlo {

template <Arithmetic kArithmetic>
inline constexpr bool kConstantTime = kArithmetic == Arithmetic::kDeterministic;

/// `usual` where the condition holds, as it usually does, else `other`: bit for bit, not-a-numbers included.
/// Constant time is more than a conditional operator: compilers make branches of those.
template <Arithmetic kArithmetic, class T>
NLO_INLINE constexpr T select(bool condition, T usual, T other) {
  if constexpr (!kConstantTime<kArithmetic>) {
    if (condition) [[likely]]
      return usual;
    return other;
  } else {
    using Mask = std::conditional_t<sizeof(T) == 8, std::uint64_t, std::uint32_t>;  // at least a register wide
    using Small = std::conditional_t<sizeof(T) == 1, std::uint8_t, std::uint16_t>;
    using Bits = std::conditional_t<sizeof(T) <= 2, Small, Mask>;
    Mask mask = Mask{0} - Mask{condition};
    // The compiler cannot see through this, so it cannot turn the mask back into a branch.
    if (!std::is_constant_evaluated()) asm("" : "+r"(mask));
    const Mask from_usual = Mask{std::bit_cast<Bits>(usual)} & mask,
               from_other = Mask{std::bit_cast<Bits>(other)} & ~mask;
    return std::bit_cast<T>(static_cast<Bits>(from_usual | from_other));
  }
}

/// True where the policy may skip work that changes nothing.
template <Arithmetic kArithmetic>
NLO_INLINE constexpr bool may_skip(bool changes_nothing) {
  return !kConstantTime<kArithmetic> && changes_nothing;
}

}  // namespace nlo
