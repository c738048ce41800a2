// SPDX-License-Identifier: MIT
// SIMD vectors by the compiler's vector extensions: one spelling for x86, Arm and RISC-V, and none at all where the
// target has no vector unit (kLanes = 1: plain scalars). Arithmetic operators are the compiler's own.
#pragma once

#include <type_traits>
#include <utility>

#include "nlo/kernels/arithmetic.h"

// Loops of a few rounds whose number the compiler knows: unrolled in full at every optimisation level but -O0, or four
// rounds at a time.
#if defined(__clang__)
#define NLO_UNROLL _Pragma("clang loop unroll(full)")
#define NLO_UNROLL_SOME _Pragma("clang loop unroll_count(4)")
#else
#define NLO_UNROLL _Pragma("GCC unroll 16")
#define NLO_UNROLL_SOME _Pragma("GCC unroll 4")
#endif
// A stack frame of its own: inlined, its memory would stay in use while the caller calls the next function. Worth an
// instruction or two where stacks are small.
#if defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M'
#define NLO_OWN_FRAME __attribute__((noinline))
#else
#define NLO_OWN_FRAME
#endif
// Once in a program where each operation on floats is a call.
#if defined(__ARM_ARCH_PROFILE) && !defined(__ARM_FP)
#define NLO_SHARED_WITHOUT_FPU __attribute__((noinline))
#else
#define NLO_SHARED_WITHOUT_FPU
#endif

namespace nlo::simd {

// NLO_SCALAR_KERNELS: plain scalar code on any target, e.g. to compare with.
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

/// Scalars in one register of the target; 1: scalar code.
template <class Scalar>
inline constexpr int kLanes = kVectorBytes > static_cast<int>(sizeof(Scalar))
                                  ? kVectorBytes / static_cast<int>(sizeof(Scalar))
                                  : 1;

// What every instruction set shares.
inline namespace types {

template <class Scalar, int kN>
struct PackOf {
  typedef Scalar Type __attribute__((vector_size(sizeof(Scalar) * kN)));
  // In memory: neuron rows start anywhere, and the weights are plain arrays of scalars.
  typedef Scalar InMemory __attribute__((vector_size(sizeof(Scalar) * kN), aligned(alignof(Scalar)), may_alias));
};
template <class Scalar>
struct PackOf<Scalar, 1> {
  using Type = Scalar;
  using InMemory = Scalar;
};

/// kN scalars side by side.
template <class Scalar, int kN = kLanes<Scalar>>
using Pack = typename PackOf<Scalar, kN>::Type;

/// The scalar of a pack, or of a scalar.
template <class T, bool kIsScalar = std::is_floating_point_v<T>>
struct ScalarOf {
  using Type = T;
};
template <class T>
struct ScalarOf<T, false> {
  using Type = std::remove_cvref_t<decltype(std::declval<T&>()[0])>;
};

/// A literal in the scalar type of T, to combine with a T.
template <class T>
NLO_INLINE constexpr auto literal(double value) {
  return static_cast<typename ScalarOf<T>::Type>(value);
}

}  // namespace types

// What works on vectors, for the instruction set that the compiler may use.
inline namespace native {
#define NLO_CODE NLO_INLINE
#define NLO_ISA_BYTES NLO_NATIVE_BYTES
#include "nlo/kernels/per_isa/vectors.inc"
#undef NLO_ISA_BYTES
#undef NLO_CODE
}  // namespace native

}  // namespace nlo::simd

namespace nlo {
using simd::multiply_add;
using simd::rounded;
}  // namespace nlo
