// SPDX-License-Identifier: MIT
// The two rounding policies of an observer, and the check of the language version. A template parameter of the observer
// chooses the policy:
//   nlo::KklObserver<Model, nlo::Arithmetic::kDeterministic> observer{kModel};
#pragma once

// Every header includes this one first, so that an older language version gives a single error with the remedy.
#if __cplusplus < 202002L
#error "nlo needs C++20: compile with -std=c++20 or -std=gnu++20 (CMake: link nlo::runtime, which asks for it)"
// This file does not exist. A missing file stops the compiler; #error alone would be followed by hundreds of errors.
#define NLO_STOP "nlo/stopped_by_the_error_above"
#include NLO_STOP
#endif

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

/// With the deterministic policy code executes the same number of instructions for every input, and so never branches on
/// data. The fast policy branches: the processor predicts the usual case and does not wait for the comparison.
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

/// Returns true if the condition holds and the policy may skip work that has no effect.
template <Arithmetic kArithmetic>
NLO_INLINE constexpr bool may_skip(bool changes_nothing) {
  return !kConstantTime<kArithmetic> && changes_nothing;
}

}  // namespace nlo
