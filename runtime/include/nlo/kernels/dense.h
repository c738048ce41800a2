// SPDX-License-Identifier: MIT
// One layer of a network, and a chain of them, by the kernel of the target; and the layout of weights for that kernel.
// The architecture and the type of the weights decide which kernel it is, never the instruction sets that the compiler
// may use: the same model has the same bytes in all objects of a program.
//   cortex_m.h  Cortex-M cores with an FPU, float
//   panels.h    CPUs with vectors, whatever their length
//   plain.h     the others, and NLO_SCALAR_KERNELS: to compare with
#pragma once

#include <type_traits>

#include "nlo/kernels/cortex_m.h"
#include "nlo/kernels/panels.h"
#include "nlo/kernels/plain.h"
#include "nlo/kernels/x86_dispatch.h"

namespace nlo::kernels {

#if defined(NLO_CORTEX_M_FLOAT)
template <class Weight>
inline constexpr bool kUsesCortexM = std::is_same_v<Weight, float>;
#else
template <class Weight>
inline constexpr bool kUsesCortexM = false;
#endif

/// The layout of a layer's weights and biases on targets without vectors.
template <class Weight, int kIn, int kOut>
struct TargetLayout {
  static constexpr int kWeights = kIn * kOut;
  static constexpr int kBiases = kOut;

  /// Position of the weight of input i for output o.
  static constexpr int weight_position(int o, int i) {
    if constexpr (kUsesCortexM<Weight>) {
      return cortex_m::weight_position<kIn, kOut>(o, i);
    } else {
      return plain::weight_position<kIn, kOut>(o, i);
    }
  }
};

/// Inputs of a first layer must be in a buffer with zeros behind them.
template <int kIn>
inline constexpr bool kPadsInputs = kIn >= 16 && kIn % 4 != 0 && kHasVectors;

/// out = f(W in + bias) with the activation f; without it in the last layer, which writes exactly kOut values. Other
/// layers write padded(kOut). `in` is padded likewise; `out` must not overlap it.
template <Activation kKind, Arithmetic kArithmetic, bool kLast, int kIn, int kOut, class Weight, class Scalar>
NLO_INLINE void layer(const Weight* weights, const Scalar* bias, const Scalar* in, Scalar* out) {
  if constexpr (kUsesCortexM<Weight>) {
#if defined(NLO_CORTEX_M_FLOAT)
    cortex_m::layer<kKind, kArithmetic, kLast, kIn, kOut>(weights, bias, in, out);
#endif
  } else if constexpr (kHasVectors) {
    native::layer<kKind, kArithmetic, kLast, kIn, kOut>(weights, bias, in, out);
  } else {
    plain::layer<kKind, kArithmetic, kLast, kIn, kOut>(weights, bias, in, out);
  }
}

#define NLO_CODE NLO_INLINE
#include "nlo/kernels/per_isa/gated.inc"
#include "nlo/kernels/per_isa/network.inc"
#include "nlo/kernels/per_isa/tangent.inc"
#undef NLO_CODE

/// The same by the best instruction set: the compiler's, or with NLO_CPU_DISPATCH the CPU's.
template <Activation kKind, Arithmetic kArithmetic, class Network, class Scalar>
NLO_INLINE void evaluate(const Network& net, const Scalar* in, Scalar* out, Scalar* ping, Scalar* pong) {
#if defined(NLO_DISPATCHES)
  switch (x86::level()) {
    case x86::Level::kAvx512:
      return x86::evaluate_avx512<kKind, kArithmetic>(net, in, out, ping, pong);
    case x86::Level::kAvx2:
      return x86::evaluate_avx2<kKind, kArithmetic>(net, in, out, ping, pong);
    default:
      break;
  }
#endif
  network<kKind, kArithmetic>(net, in, out, ping, pong);
}

/// The forward-mode product, likewise; see network_jvp().
template <Activation kKind, class Network, class Scalar, class Buffer>
NLO_INLINE void jvp(const Network& net, const Scalar* in, const Scalar* direction, Scalar* out, Buffer& ping,
                    Buffer& pong) {
#if defined(NLO_DISPATCHES)
  switch (x86::level()) {
    case x86::Level::kAvx512:
      return x86::jvp_avx512<kKind>(net, in, direction, out, ping, pong);
    case x86::Level::kAvx2:
      return x86::jvp_avx2<kKind>(net, in, direction, out, ping, pong);
    default:
      break;
  }
#endif
  network_jvp<kKind>(net, in, direction, out, ping, pong);
}

/// A step of gated units, likewise; see gated_units().
template <Arithmetic kArithmetic, bool kRegular, int kNz, class Gates, class Candidate, class Scalar>
NLO_INLINE void gated_step(const Gates& gates, const Candidate& candidate, Scalar* in, Scalar* gate, Scalar* target,
                           Scalar (&z)[kNz], Scalar periods) {
#if defined(NLO_DISPATCHES)
  switch (x86::level()) {
    case x86::Level::kAvx512:
      return x86::gated_step_avx512<kArithmetic, kRegular>(gates, candidate, in, gate, target, z, periods);
    case x86::Level::kAvx2:
      return x86::gated_step_avx2<kArithmetic, kRegular>(gates, candidate, in, gate, target, z, periods);
    default:
      break;
  }
#endif
  gated_units<kArithmetic, kRegular>(gates, candidate, in, gate, target, z, periods);
}

/// Plants side by side that keep an instruction set of that many bytes busy: two vectors of them.
template <class Scalar, int kBytes>
inline constexpr int kBatchBlock = 2 * (kBytes > static_cast<int>(sizeof(Scalar))
                                            ? kBytes / static_cast<int>(sizeof(Scalar))
                                            : 1);

/// The most that for_batch_block() may ask for.
#if defined(NLO_DISPATCHES)
template <class Scalar>
inline constexpr int kMostBatchBlock = kBatchBlock<Scalar, 64>;
#else
template <class Scalar>
inline constexpr int kMostBatchBlock = kBatchBlock<Scalar, NLO_NATIVE_BYTES>;
#endif

/// Calls work(std::integral_constant<int, kPlants>) with the kPlants for evaluate_batch() that suit the CPU.
template <class Scalar, class Work>
NLO_INLINE void for_batch_block(const Work& work) {
#if defined(NLO_DISPATCHES)
  switch (x86::level()) {
    case x86::Level::kAvx512:
      return work(std::integral_constant<int, kBatchBlock<Scalar, 64>>{});
    case x86::Level::kAvx2:
      return work(std::integral_constant<int, kBatchBlock<Scalar, 32>>{});
    default:
      break;
  }
#endif
  work(std::integral_constant<int, kBatchBlock<Scalar, NLO_NATIVE_BYTES>>{});
}

/// Many inputs at once, kPlants of them side by side; buffers [widest][kPlants]. One by one where kPlants is not what
/// suits the CPU.
template <Activation kKind, Arithmetic kArithmetic, int kPlants, class Network, class Scalar>
NLO_INLINE void evaluate_batch(const Network& net, const Scalar* in, Scalar* out, Scalar* ping, Scalar* pong) {
#if defined(NLO_DISPATCHES)
  const x86::Level level = x86::level();
  if constexpr (kPlants == kBatchBlock<Scalar, 64>) {
    if (level == x86::Level::kAvx512)
      return x86::evaluate_batch_avx512<kKind, kArithmetic, kPlants>(net, in, out, ping, pong);
  }
  if constexpr (kPlants == kBatchBlock<Scalar, 32>) {
    if (level == x86::Level::kAvx2)
      return x86::evaluate_batch_avx2<kKind, kArithmetic, kPlants>(net, in, out, ping, pong);
  }
#endif
  if constexpr (kHasVectors && kPlants == kBatchBlock<Scalar, NLO_NATIVE_BYTES>) {
    native::batch_network<kKind, kArithmetic, kPlants>(net, in, out, ping, pong);
  } else {
    for (int n = 0; n < kPlants; ++n) {
      Scalar one_in[Network::kIn], one_out[Network::kOut];
      for (int i = 0; i < Network::kIn; ++i) one_in[i] = in[i * kPlants + n];
      evaluate<kKind, kArithmetic>(net, one_in, one_out, ping, pong);
      for (int o = 0; o < Network::kOut; ++o) out[o * kPlants + n] = one_out[o];
    }
  }
}

}  // namespace nlo::kernels
