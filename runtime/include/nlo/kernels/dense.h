// SPDX-License-Identifier: MIT
// One layer of a network by the kernel of the target, and where its weights lie for that kernel.
#pragma once

#include <type_traits>

#include "nlo/kernels/cortex_m.h"
#include "nlo/kernels/generic.h"

namespace nlo::kernels {

/// The assembly of Cortex-M cores with an FPU. Double has no FPU there.
#if defined(NLO_CORTEX_M_FLOAT)
template <class Scalar>
inline constexpr bool kUsesCortexM = std::is_same_v<Scalar, float>;
#else
template <class Scalar>
inline constexpr bool kUsesCortexM = false;
#endif

/// Where the weight of input i for output o lies among the kIn kOut weights of a packed layer.
template <class Scalar, int kIn, int kOut>
constexpr int weight_position(int o, int i) {
  if constexpr (kUsesCortexM<Scalar>) {
    return cortex_m::weight_position<kIn, kOut>(o, i);
  } else {
    return kByColumns<kIn, kOut> ? i * kOut + o : o * kIn + i;
  }
}

/// out = f(W in + bias) with the activation f, or without one in the last layer. `out` must not overlap `in`.
template <Activation kKind, Arithmetic kArithmetic, bool kLast, int kIn, int kOut, class Scalar>
NLO_INLINE void layer(const Scalar* weights, const Scalar* bias, const Scalar* in, Scalar* out) {
  if constexpr (kUsesCortexM<Scalar>) {
#if defined(NLO_CORTEX_M_FLOAT)
    cortex_m::layer<kKind, kArithmetic, kLast, kIn, kOut>(weights, bias, in, out);
#endif
  } else {
    using Function = std::conditional_t<kLast, Identity, Activate<kKind, kArithmetic>>;
    dense<kArithmetic, Scalar, kIn, kOut>(weights, bias, in, out, Function{});
  }
}

}  // namespace nlo::kernels
