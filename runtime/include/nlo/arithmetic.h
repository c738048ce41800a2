// SPDX-License-Identifier: MIT
// The two ways in which an observer may round. A template parameter of the observer chooses:
//   nlo::KklObserver<Model, nlo::Arithmetic::kDeterministic> observer{kModel};
#pragma once

#include <cstdint>
#include <type_traits>

#include "nlo/simd.h"

namespace nlo {

enum class Arithmetic : std::uint8_t {
  kFast,           ///< sums in the order that suits the target, fused multiply-adds where it has them
  kDeterministic,  ///< one order, each operation rounded by itself: the same bits on every IEEE 754 target, compiler
                   ///< and optimisation level (but not with -ffast-math)
};

/// The value, rounded to its type: an addition that follows cannot be fused with the product that it is. GCC and clang
/// differ in when they fuse, and their flags and pragmas do not reach code that is inlined elsewhere; this does.
template <class T>
NLO_INLINE constexpr T rounded(T value) {
  if constexpr (!std::is_class_v<T>) {
    if (!std::is_constant_evaluated()) {
#if defined(__AVX512F__)
      asm("" : "+v"(value));
#elif defined(__SSE2__)
      asm("" : "+x"(value));
#elif defined(__aarch64__)
      asm("" : "+w"(value));
#elif defined(__arm__)
      // In an FPU register where the FPU knows the type (bits of __ARM_FP: 4 single, 8 double), else in core registers.
#if defined(__ARM_FP) && (__ARM_FP & 8)
      asm("" : "+w"(value));
#elif defined(__ARM_FP)
      if constexpr (sizeof(T) == 4) {
        asm("" : "+t"(value));
      } else {
        asm("" : "+r"(value));
      }
#else
      asm("" : "+r"(value));
#endif
#else
      asm("" : "+m"(value));
#endif
    }
  }
  return value;
}

/// a b + c, rounded as the policy says.
template <Arithmetic kArithmetic, class T>
NLO_INLINE constexpr T multiply_add(T a, T b, T c) {
  if constexpr (kArithmetic == Arithmetic::kDeterministic) {
    return rounded<T>(a * b) + c;
  } else {
    return a * b + c;
  }
}

}  // namespace nlo
