// SPDX-License-Identifier: MIT
// Chooses the kernel of the target for a layer, and with it the layout of the weights. The choice depends on the
// architecture and on the type of the weights, never on the instruction sets that the compiler may use. Therefore a
// model has the same bytes in all objects of a program.
//   panels.h           CPUs with vectors of any length
//   without_vectors.h  CPUs without vectors, and NLO_SCALAR_KERNELS (for comparisons)
//   x86_dispatch.h     with NLO_CPU_DISPATCH, the best instruction set of the CPU
#pragma once

#include <type_traits>

#include "nlo/kernels/activation.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/panels.h"
#if !NLO_HAS_VECTORS
#include "nlo/kernels/without_vectors.h"
#endif
#if defined(NLO_CPU_DISPATCH)
#include "nlo/kernels/x86_dispatch.h"
#endif

namespace nlo::inline NLO_ISA {

/// A layer in the layout of the kernel.
#if NLO_HAS_VECTORS
template <class Weight, int kIn, int kOut>
using PackedDense = PanelDense<Weight, kIn, kOut>;
#else
template <class Weight, int kIn, int kOut>
using PackedDense = TargetDense<Weight, kIn, kOut>;
#endif

}  // namespace nlo::inline NLO_ISA

namespace nlo::inline NLO_ISA::kernels {

/// True if the inputs of the first layer must be padded with zeros.
template <int kIn>
inline constexpr bool kPadsInputs = kIn >= 16 && kIn % 4 != 0 && kHasVectors;

#if NLO_HAS_VECTORS
using native::layer;
#endif
#define NLO_CODE NLO_INLINE
#include "nlo/kernels/per_isa/network.inc"
#undef NLO_CODE

/// out = net(in) by the best instruction set: that of the compiler, or with NLO_CPU_DISPATCH that of the CPU.
template <Activation kKind, Arithmetic kArithmetic, class Network, class Scalar>
NLO_INLINE void evaluate(const Network& net, const Scalar* in, Scalar* out, Scalar* ping, Scalar* pong) {
#if defined(NLO_DISPATCHES)
  if (x86::dispatched([&] { x86::evaluate_one_load<kKind, kArithmetic>(net, in, out, ping, pong); },
                      [&] { x86::evaluate_avx512<kKind, kArithmetic>(net, in, out, ping, pong); },
                      [&] { x86::evaluate_avx2<kKind, kArithmetic>(net, in, out, ping, pong); }))
    return;
#endif
  network<kKind, kArithmetic>(net, in, out, ping, pong);
}

}  // namespace nlo::inline NLO_ISA::kernels
