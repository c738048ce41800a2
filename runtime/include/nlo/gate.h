// SPDX-License-Identifier: MIT
// Gates of a gated observer (gated_observer.h), and a step of its units. The tanh is that of activation.h.
//   sigmoid(2 a) = (1 + tanh a) / 2   a reset gate, or s for a step of one sample period
//   1 - exp(-periods softplus(2 a))   s for a step of any number of periods
// s is the fraction of the distance to its target that a unit covers in a step. For periods = 1 both formulas are
// equal, because exp(-softplus(v)) = 1 - sigmoid(v).
#pragma once

#include "nlo/kernels/activation.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/dense.h"
#include "nlo/latent.h"
#include "nlo/mlp.h"
#if defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M'
#include "nlo/kernels/cortex_m_gates.h"
#endif

namespace nlo::inline NLO_ISA {

/// Intermediate values of a step of kUnits gated units: 2 kUnits gates and kUnits targets.
template <class Scalar, int kUnits>
struct GateBuffers {
  // The targets may overwrite the reset gates, which are not needed any more by then. This saves a quarter of the
  // stack. With vectors the targets have a buffer of their own, because they must be aligned.
  static constexpr bool kShares = !kernels::kHasVectors;
  LayerBuffer<Scalar, 2 * kUnits> gates;
  LayerBuffer<Scalar, kShares ? 1 : kUnits> apart;
  constexpr Scalar* targets() { return kShares ? gates.values + kUnits : apart.values; }
};

/// Returns log(1 + t) = 2 atanh(t / (2 + t)) for 0 <= t <= 1; relative error below 4 rounding units. The series in
/// (t / (2 + t))^2 <= 1/9 needs 16 terms for the precision of a double.
template <class T>
constexpr T log_1_plus(T t) {
  constexpr int kTerms = 16;
  const T w = t / (T(2) + t), square = w * w;
  T series = reciprocal<T>(2 * kTerms + 1);
  for (int k = kTerms - 1; k >= 0; --k) series = rounded<T>(square * series) + reciprocal<T>(2 * k + 1);
  return rounded<T>(T(2) * w * series);
}

/// Returns s = 1 - exp(-periods softplus(2 a)), in [0, 1], for a step of `periods` sample periods. `a` is finite and
/// periods > 0. Absolute error below 4 max(1, periods) rounding units.
template <class T>
constexpr T gate_over(T a, T periods) {
  const T v = T(2) * a;
  const T decay = decay_minus_1(v < T(0) ? -v : v) + T(1);
  const T softplus = (v > T(0) ? v : T(0)) + log_1_plus(decay);
  return -decay_minus_1(rounded<T>(periods * softplus));
}

}  // namespace nlo::inline NLO_ISA

namespace nlo::inline NLO_ISA::kernels {

#if NLO_HAS_VECTORS
using native::tile;
#endif
using simd::lanes_for;
using simd::load;
using simd::Pack;
using simd::store;
#define NLO_CODE NLO_INLINE
#include "nlo/kernels/per_isa/gated.inc"
#undef NLO_CODE

#if defined(NLO_DISPATCHES)
namespace x86 {

namespace avx2 {
#define NLO_CODE NLO_CODE_AVX2
#include "nlo/kernels/per_isa/gated.inc"
#undef NLO_CODE
}  // namespace avx2

namespace avx512 {
#define NLO_CODE NLO_CODE_AVX512
#include "nlo/kernels/per_isa/gated.inc"
#undef NLO_CODE
}  // namespace avx512

namespace avx512_one_load {
#define NLO_CODE NLO_CODE_AVX512
#include "nlo/kernels/per_isa/gated.inc"
#undef NLO_CODE
}  // namespace avx512_one_load

template <Arithmetic kArithmetic, bool kRegular, int kNz, class Gates, class Candidate, class Scalar>
__attribute__((noinline, NLO_TARGET_AVX2)) void gated_step_avx2(const Gates& gates, const Candidate& candidate,
                                                                Scalar* in, Scalar* gate, Scalar* target,
                                                                Scalar (&z)[kNz], Scalar periods) {
  avx2::gated_units<kArithmetic, kRegular, avx2::OnePlant, kNz>(gates, candidate, in, gate, target, z, periods);
}

template <Arithmetic kArithmetic, bool kRegular, int kNz, class Gates, class Candidate, class Scalar>
__attribute__((noinline, NLO_TARGET_AVX512)) void gated_step_avx512(const Gates& gates, const Candidate& candidate,
                                                                    Scalar* in, Scalar* gate, Scalar* target,
                                                                    Scalar (&z)[kNz], Scalar periods) {
  avx512::gated_units<kArithmetic, kRegular, avx512::OnePlant, kNz>(gates, candidate, in, gate, target, z, periods);
}

template <Arithmetic kArithmetic, bool kRegular, int kNz, class Gates, class Candidate, class Scalar>
__attribute__((noinline, NLO_TARGET_AVX512)) void gated_step_one_load(const Gates& gates, const Candidate& candidate,
                                                                      Scalar* in, Scalar* gate, Scalar* target,
                                                                      Scalar (&z)[kNz], Scalar periods) {
  avx512_one_load::gated_units<kArithmetic, kRegular, avx512_one_load::OnePlant, kNz>(gates, candidate, in, gate,
                                                                                      target, z, periods);
}

}  // namespace x86
#endif

/// Copies kN values. Returns true if it has checked that all are below 2; false if it has not checked.
template <int kN, class Scalar>
NLO_INLINE bool copy_units(const Scalar* from, Scalar* to) {
#if defined(NLO_CORTEX_M_GATES)
  if constexpr (std::is_same_v<Scalar, float>) return cortex_m::copy_below_2<kN>(from, to);
#endif
  for (int r = 0; r < kN; ++r) to[r] = from[r];
  return false;
}

/// A step of gated units by the best instruction set of the CPU, like evaluate() of dense.h; see gated_units().
template <Arithmetic kArithmetic, bool kRegular, int kNz, class Gates, class Candidate, class Scalar>
NLO_INLINE void gated_step(const Gates& gates, const Candidate& candidate, Scalar* in, Scalar* gate, Scalar* target,
                           Scalar (&z)[kNz], Scalar periods) {
#if defined(NLO_DISPATCHES)
  if (x86::dispatched(
          [&] { x86::gated_step_one_load<kArithmetic, kRegular>(gates, candidate, in, gate, target, z, periods); },
          [&] { x86::gated_step_avx512<kArithmetic, kRegular>(gates, candidate, in, gate, target, z, periods); },
          [&] { x86::gated_step_avx2<kArithmetic, kRegular>(gates, candidate, in, gate, target, z, periods); }))
    return;
#elif defined(NLO_CORTEX_M_GATES)
  if constexpr (kRegular && std::is_same_v<Scalar, float>) {
    constexpr bool kFused = kArithmetic == Arithmetic::kFast && cortex_m::kFuses;
    OnePlant::evaluate<kArithmetic, false>(gates, in, gate);
    cortex_m::reset_units<kFused, kNz>(gate + kNz, z, in);
    OnePlant::evaluate<kArithmetic, false>(candidate, in, target);
    return cortex_m::move_units<kFused, kNz>(gate, target, z);
  }
#endif
  gated_units<kArithmetic, kRegular, OnePlant, kNz>(gates, candidate, in, gate, target, z, periods);
}

}  // namespace nlo::inline NLO_ISA::kernels

namespace nlo::inline NLO_ISA {
using kernels::gate_of;
}  // namespace nlo::inline NLO_ISA
