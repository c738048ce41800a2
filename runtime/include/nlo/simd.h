// SPDX-License-Identifier: MIT
// SIMD vectors by the compiler's vector extensions: one spelling for x86, Arm and RISC-V, and none at all where the
// target has no vector unit (kLanes = 1: plain scalars). Arithmetic operators are the compiler's own.
#pragma once

#include <type_traits>
#include <utility>

#define NLO_INLINE inline __attribute__((always_inline))
#define NLO_INLINE_LAMBDA __attribute__((always_inline))
// A frame that is gone when the function returns: inlined, its room on the stack would stay taken while the caller
// calls the next one. Worth an instruction or two where stacks are small.
#if defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M'
#define NLO_OWN_FRAME __attribute__((noinline))
#else
#define NLO_OWN_FRAME
#endif

namespace nlo::simd {

// NLO_SCALAR_KERNELS: plain scalar code on any target, e.g. to compare with.
#if defined(NLO_SCALAR_KERNELS)
inline constexpr int kVectorBytes = 4;
#elif defined(__AVX512F__)
inline constexpr int kVectorBytes = 64;
#elif defined(__AVX__)
inline constexpr int kVectorBytes = 32;
#elif defined(__SSE2__) || defined(__ARM_NEON)
inline constexpr int kVectorBytes = 16;
#else
inline constexpr int kVectorBytes = 4;
#endif

/// Scalars in one register of the target; 1: scalar code.
template <class Scalar>
inline constexpr int kLanes = kVectorBytes > static_cast<int>(sizeof(Scalar))
                                  ? kVectorBytes / static_cast<int>(sizeof(Scalar))
                                  : 1;

template <class Scalar, int kN>
struct PackOf {
  typedef Scalar Type __attribute__((vector_size(sizeof(Scalar) * kN)));
  // As it lies in memory: neuron rows start anywhere, and the weights are plain arrays of scalars.
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

template <class P, class Scalar>
NLO_INLINE P load(const Scalar* from) {
  return *reinterpret_cast<const typename PackOf<Scalar, sizeof(P) / sizeof(Scalar)>::InMemory*>(from);
}

template <class P, class Scalar>
NLO_INLINE void store(Scalar* to, P value) {
  *reinterpret_cast<typename PackOf<Scalar, sizeof(P) / sizeof(Scalar)>::InMemory*>(to) = value;
}

template <class P, class Scalar>
NLO_INLINE P broadcast(Scalar value) {
  return value - P{};  // folds to a broadcast: v - 0 is v, signed zeros included
}

/// The smaller of each pair of lanes; `limit` where x is not a number. x86's own instructions: compilers make a compare
/// and a blend of the portable form.
template <class P>
NLO_INLINE constexpr P min(P x, P limit) {
#if defined(__SSE2__)
  if (!std::is_constant_evaluated()) {
    if constexpr (std::is_same_v<P, Pack<float, 4>>) return __builtin_ia32_minps(x, limit);
#if defined(__AVX__)
    if constexpr (std::is_same_v<P, Pack<float, 8>>) return __builtin_ia32_minps256(x, limit);
#endif
  }
#endif
  return x < limit ? x : limit;
}
template <class P>
NLO_INLINE constexpr P max(P x, P limit) {
#if defined(__SSE2__)
  if (!std::is_constant_evaluated()) {
    if constexpr (std::is_same_v<P, Pack<float, 4>>) return __builtin_ia32_maxps(x, limit);
#if defined(__AVX__)
    if constexpr (std::is_same_v<P, Pack<float, 8>>) return __builtin_ia32_maxps256(x, limit);
#endif
  }
#endif
  return x > limit ? x : limit;
}

/// Keeps a value in a register across the uses that follow: compilers like to read it from memory once per use, and
/// a tile of a matrix product is then bound by loads.
template <class P>
NLO_INLINE void pin(P& value) {
#if defined(__AVX__)
  asm("" : "+v"(value));
#else
  (void)value;
#endif
}

/// Sum of the lanes, pairwise.
template <class Scalar, class P>
NLO_INLINE Scalar sum(P value) {
  constexpr int kN = sizeof(P) / sizeof(Scalar);
  if constexpr (kN == 1) {
    return value;
  } else {
    Scalar lanes[kN];
    store(lanes, value);
    for (int half = kN / 2; half > 0; half /= 2) {
      for (int i = 0; i < half; ++i) lanes[i] += lanes[i + half];
    }
    return lanes[0];
  }
}

}  // namespace nlo::simd
