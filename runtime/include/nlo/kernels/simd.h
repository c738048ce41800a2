// SPDX-License-Identifier: MIT
// SIMD vectors by the vector extensions of the compiler, written alike for x86, Arm and RISC-V, with the compiler's
// arithmetic operators. On a target without a vector unit a vector is a scalar (kLanes = 1).
#pragma once

#include <type_traits>
#include <utility>

#include "nlo/kernels/arithmetic.h"

// Unrolls a short loop with a constant number of rounds, completely or four rounds at a time, at every optimisation
// level but -O0.
#if defined(__clang__)
#define NLO_UNROLL _Pragma("clang loop unroll(full)")
#define NLO_UNROLL_SOME _Pragma("clang loop unroll_count(4)")
#else
#define NLO_UNROLL _Pragma("GCC unroll 16")
#define NLO_UNROLL_SOME _Pragma("GCC unroll 4")
#endif
// Gives a function its own stack frame. If it were inlined, its memory would stay in use during the next call of the
// caller. This costs an instruction or two and saves stack on small targets.
#if defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M'
#define NLO_OWN_FRAME __attribute__((noinline))
#else
#define NLO_OWN_FRAME
#endif
// Not inlined on targets without an FPU, where every operation on floats is a function call.
#if defined(__ARM_ARCH_PROFILE) && !defined(__ARM_FP)
#define NLO_SHARED_WITHOUT_FPU __attribute__((noinline))
#else
#define NLO_SHARED_WITHOUT_FPU
#endif

namespace nlo::inline NLO_ISA::simd {

// NLO_SCALAR_KERNELS selects plain scalar code on any target, for comparisons.
#if defined(NLO_SCALAR_KERNELS)
#define NLO_NATIVE_BYTES 4
#elif defined(__AVX512F__)
#define NLO_NATIVE_BYTES 64
#elif defined(__AVX__)
#define NLO_NATIVE_BYTES 32
#elif defined(__SSE2__) || defined(__ARM_NEON)
#define NLO_NATIVE_BYTES 16
#else
#define NLO_NATIVE_BYTES 4
#endif
inline constexpr int kVectorBytes = NLO_NATIVE_BYTES;

/// Number of scalars in a vector register of the target; 1: no vectors.
template <class Scalar>
inline constexpr int kLanes = kVectorBytes > static_cast<int>(sizeof(Scalar))
                                  ? kVectorBytes / static_cast<int>(sizeof(Scalar))
                                  : 1;

// Types that all instruction sets share.
inline namespace types {

template <class Scalar, int kN>
struct PackOf {
  typedef Scalar Type __attribute__((vector_size(sizeof(Scalar) * kN)));
  // A vector in memory: rows of weights are not aligned, and weights are plain arrays of scalars.
  typedef Scalar InMemory __attribute__((vector_size(sizeof(Scalar) * kN), aligned(alignof(Scalar)), may_alias));
};
template <class Scalar>
struct PackOf<Scalar, 1> {
  using Type = Scalar;
  using InMemory = Scalar;
};

/// A vector of kN scalars; for kN = 1 the scalar itself.
template <class Scalar, int kN = kLanes<Scalar>>
using Pack = typename PackOf<Scalar, kN>::Type;

/// Scalar type of a vector, or of a scalar.
template <class T, bool kIsScalar = std::is_floating_point_v<T>>
struct ScalarOf {
  using Type = T;
};
template <class T>
struct ScalarOf<T, false> {
  using Type = std::remove_cvref_t<decltype(std::declval<T&>()[0])>;
};

/// Returns a literal in the scalar type of T, for arithmetic with a T.
template <class T>
NLO_INLINE constexpr auto literal(double value) {
  return static_cast<typename ScalarOf<T>::Type>(value);
}

}  // namespace types

// Functions on vectors, for the instruction set that the compiler may use.
inline namespace native {
#define NLO_CODE NLO_INLINE
#define NLO_ISA_BYTES NLO_NATIVE_BYTES
#include "nlo/kernels/per_isa/vectors.inc"
#undef NLO_ISA_BYTES
#undef NLO_CODE
}  // namespace native

}  // namespace nlo::inline NLO_ISA::simd

namespace nlo::inline NLO_ISA {
using simd::multiply_add;
using simd::rounded;
}  // namespace nlo::inline NLO_ISA
