// SPDX-License-Identifier: MIT
// What all code of the runtime rests on: its language, and the two ways in which an observer may round. A template
// parameter of the observer chooses:
//   nlo::KklObserver<Model, nlo::Arithmetic::kDeterministic> observer{kModel};
#pragma once

// An older language gets one error that says what to do, and the compiler stops there: headers begin with this one.
#if __cplusplus < 202002L
#error "nlo needs C++20: compile with -std=c++20 or -std=gnu++20 (CMake: link nlo::runtime, which asks for it)"
// No file has this name: to miss it ends the compilation, where hundreds of errors would follow.
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
  kFast,           ///< sums in the order that suits the target, fused multiply-adds where it has them
  kDeterministic,  ///< one order, each operation rounded by itself: the same bits on every IEEE 754 target, compiler
                   ///< and optimisation level (but not with -ffast-math)
};

/// The deterministic policy takes as many instructions whatever is measured, and so never branches on data. The fast
/// policy branches: a processor predicts the usual side, and the next step need not wait for the comparison.
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
