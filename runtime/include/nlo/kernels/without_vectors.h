// SPDX-License-Identifier: MIT
// Chooses the kernel for targets other than those of panels.h, and with it the layout of the weights:
//   cortex_m.h          Cortex-M cores with an FPU, for float
//   cortex_m_vectors.h  Cortex-M cores with vectors of floats (MVE)
//   riscv_vectors.h     RISC-V cores with vectors of floats
//   plain.h             all others
#pragma once

#include <type_traits>

#include "nlo/kernels/activation.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/panels.h"
#include "nlo/kernels/plain.h"
#if defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M'
#include "nlo/kernels/cortex_m.h"
#include "nlo/kernels/cortex_m_vectors.h"
#endif
#if defined(__riscv_vector)
#include "nlo/kernels/riscv_vectors.h"
#endif

namespace nlo::inline NLO_ISA::kernels {

// The kernel of this target for weights in float. Other weights use plain.h.
#if defined(NLO_CORTEX_M_MVE)
namespace target = cortex_m_vectors;
#elif defined(NLO_CORTEX_M_FLOAT)
namespace target = cortex_m;
#elif defined(NLO_RISCV_VECTORS)
namespace target = riscv_vectors;
#else
namespace target = plain;
#define NLO_ONLY_PLAIN true
#endif
#if !defined(NLO_ONLY_PLAIN)
#define NLO_ONLY_PLAIN false
#endif
template <class Weight>
inline constexpr bool kIsPlain = NLO_ONLY_PLAIN || !std::is_same_v<Weight, float>;
#undef NLO_ONLY_PLAIN

/// Layout of the weights and biases of a layer.
template <class Weight, int kIn, int kOut>
struct TargetLayout {
#if defined(NLO_CORTEX_M_MVE)
  static constexpr int kBiases = kIsPlain<Weight> ? kOut : rounded_up(kOut, 4);
#else
  static constexpr int kBiases = kOut;
#endif
  static constexpr int kWeights = kIn * kBiases;

  /// Returns the position of the weight of input i for output o.
  static constexpr int weight_position(int o, int i) {
    if constexpr (kIsPlain<Weight>) return plain::weight_position<kIn, kOut>(o, i);
    return target::weight_position<kIn, kOut>(o, i);
  }
};

/// out = f(W in + bias), in the last layer without the activation f. `out` must not overlap `in`.
template <Activation kKind, Arithmetic kArithmetic, bool kLast, int kIn, int kOut, class Weight, class Scalar>
NLO_INLINE void layer(const Weight* weights, const Scalar* bias, const Scalar* in, Scalar* out) {
  if constexpr (kIsPlain<Weight>) {
    plain::layer<kKind, kArithmetic, kLast, kIn, kOut>(weights, bias, in, out);
  } else {
    target::layer<kKind, kArithmetic, kLast, kIn, kOut>(weights, bias, in, out);
  }
}

}  // namespace nlo::inline NLO_ISA::kernels

namespace nlo::inline NLO_ISA {

/// A layer in this layout.
template <class Weight, int kIn_, int kOut_>
struct TargetDense {
  using Layout = kernels::TargetLayout<Weight, kIn_, kOut_>;
  using Scalar = typename ComputesIn<Weight>::Type;
  static constexpr int kIn = kIn_;
  static constexpr int kOut = kOut_;
  Weight weights[Layout::kWeights];
  Scalar bias[Layout::kBiases];
};

}  // namespace nlo::inline NLO_ISA
