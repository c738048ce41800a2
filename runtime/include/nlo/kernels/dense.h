// SPDX-License-Identifier: MIT
// One layer of a network, and a chain of them, by the kernel of the target; and the layout of weights for that kernel.
// The architecture and the type of the weights decide which kernel it is, never the instruction sets that the compiler
// may use: the same model has the same bytes in all objects of a program.
//   panels.h           CPUs with vectors, whatever their length
//   without_vectors.h  the others, and NLO_SCALAR_KERNELS: to compare with
//   x86_dispatch.h     with NLO_CPU_DISPATCH, by the instruction set that the CPU has
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

namespace nlo {

/// One layer as it is executed.
#if NLO_HAS_VECTORS
template <class Weight, int kIn, int kOut>
using PackedDense = PanelDense<Weight, kIn, kOut>;
#else
template <class Weight, int kIn, int kOut>
using PackedDense = TargetDense<Weight, kIn, kOut>;
#endif

}  // namespace nlo

namespace nlo::kernels {

/// Inputs of a first layer must be in a buffer with zeros behind them.
template <int kIn>
inline constexpr bool kPadsInputs = kIn >= 16 && kIn % 4 != 0 && kHasVectors;

#if NLO_HAS_VECTORS
using native::layer;
#endif
#define NLO_CODE NLO_INLINE
#include "nlo/kernels/per_isa/network.inc"
#undef NLO_CODE

/// The same by the best instruction set: the compiler's, or with NLO_CPU_DISPATCH the CPU's.
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

}  // namespace nlo::kernels
