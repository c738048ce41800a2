// SPDX-License-Identifier: MIT
// The two rounding policies of an observer. A template parameter of the observer chooses the policy:
//   nlo::KklObserver<Model, nlo::Arithmetic::kDeterministic> observer{kModel};
#pragma once

#include "nlo/kernels/compiler.h"

#include <bit>
#include <cstdint>
#include <type_traits>

#define NLO_INLINE inline __attribute__((always_inline))
#define NLO_INLINE_LAMBDA __attribute__((always_inline))

namespace nlo {

enum class Arithmetic : std::uint8_t {
  kFast,           ///< order of sums as the target prefers, with fused multiply-adds if it has them
  kDeterministic,  ///< fixed order, each operation rounded by itself: the same bits on every IEEE 754 target, compiler
                   ///< and optimisation level (except with -ffast-math)
};

}  // namespace nlo

namespace nlo::inline NLO_ISA {

/// With the deterministic policy code executes the same number of instructions for every input, and so never branches
/// on data. The fast policy branches: the processor predicts the usual case and does not wait for the comparison.
template <Arithmetic kArithmetic>
inline constexpr bool kConstantTime = kArithmetic == Arithmetic::kDeterministic;

/// Returns `usual` if the condition holds, as it usually does, else `other`, bit for bit, NaN included. A conditional
/// operator is not enough for constant time, because compilers may turn it into a branch.
template <Arithmetic kArithmetic, class T>
NLO_INLINE constexpr T select(bool condition, T usual, T other) {
  if constexpr (!kConstantTime<kArithmetic>) {
    if (condition) [[likely]]
      return usual;
    return other;
  } else {
    using Mask = std::conditional_t<sizeof(T) == 8, std::uint64_t, std::uint32_t>;  // 32 bits or more: registers
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

/// Returns true if the condition holds and the policy may skip work that has no effect.
template <Arithmetic kArithmetic>
NLO_INLINE constexpr bool may_skip(bool changes_nothing) {
  return !kConstantTime<kArithmetic> && changes_nothing;
}

}  // namespace nlo::inline NLO_ISA
