// SPDX-License-Identifier: MIT
// Evaluates a chain of layers for many inputs at once, so that every weight is loaded once for all of them.
#pragma once

#include <type_traits>

#include "nlo/kernels/activation.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/dense.h"
#include "nlo/kernels/simd.h"

#if NLO_HAS_VECTORS
namespace nlo::inline NLO_ISA::kernels::native {
#define NLO_CODE NLO_INLINE
#define NLO_ISA_BYTES NLO_NATIVE_BYTES
#include "nlo/kernels/per_isa/batch.inc"
#undef NLO_ISA_BYTES
#undef NLO_CODE
}  // namespace nlo::inline NLO_ISA::kernels::native
#endif

namespace nlo::inline NLO_ISA::kernels {

/// Number of plants in a block: two vectors of an instruction set with vectors of kBytes bytes.
template <class Scalar, int kBytes>
inline constexpr int kBatchBlock = 2 * (kBytes > static_cast<int>(sizeof(Scalar))
                                            ? kBytes / static_cast<int>(sizeof(Scalar))
                                            : 1);

/// Largest block that for_batch_block() chooses.
#if defined(NLO_DISPATCHES)
template <class Scalar>
inline constexpr int kMostBatchBlock = kBatchBlock<Scalar, 64>;
#else
template <class Scalar>
inline constexpr int kMostBatchBlock = kBatchBlock<Scalar, NLO_NATIVE_BYTES>;
#endif

/// Calls work(std::integral_constant<int, kPlants>) with the block size kPlants that suits the CPU.
template <class Scalar, class Work>
NLO_INLINE void for_batch_block(const Work& work) {
#if defined(NLO_DISPATCHES)
  switch (x86::level()) {
    case x86::Level::kAvx512:
    case x86::Level::kAvx512OneLoad:
      return work(std::integral_constant<int, kBatchBlock<Scalar, 64>>{});
    case x86::Level::kAvx2:
      return work(std::integral_constant<int, kBatchBlock<Scalar, 32>>{});
    default:
      break;
  }
#endif
  work(std::integral_constant<int, kBatchBlock<Scalar, NLO_NATIVE_BYTES>>{});
}

/// Evaluates a network for kPlants inputs; buffers are [widest][kPlants]. If kPlants does not suit the CPU, the inputs
/// are evaluated one by one.
template <Activation kKind, Arithmetic kArithmetic, int kPlants, class Network, class Scalar>
NLO_INLINE void evaluate_batch(const Network& net, const Scalar* in, Scalar* out, Scalar* ping, Scalar* pong) {
#if defined(NLO_DISPATCHES)
  const x86::Level level = x86::level();
  if constexpr (kPlants == kBatchBlock<Scalar, 64>) {
    if (x86::has_avx512(level))
      return x86::evaluate_batch_avx512<kKind, kArithmetic, kPlants>(net, in, out, ping, pong);
  }
  if constexpr (kPlants == kBatchBlock<Scalar, 32>) {
    if (level == x86::Level::kAvx2)
      return x86::evaluate_batch_avx2<kKind, kArithmetic, kPlants>(net, in, out, ping, pong);
  }
#endif
  constexpr bool kTogether = kHasVectors && kPlants == kBatchBlock<Scalar, NLO_NATIVE_BYTES>;
#if NLO_HAS_VECTORS
  if constexpr (kTogether) native::batch_network<kKind, kArithmetic, kPlants>(net, in, out, ping, pong);
#endif
  if constexpr (!kTogether) {
    for (int n = 0; n < kPlants; ++n) {
      Scalar one_in[Network::kIn], one_out[Network::kOut];
      for (int i = 0; i < Network::kIn; ++i) one_in[i] = in[i * kPlants + n];
      evaluate<kKind, kArithmetic>(net, one_in, one_out, ping, pong);
      for (int o = 0; o < Network::kOut; ++o) out[o * kPlants + n] = one_out[o];
    }
  }
}

}  // namespace nlo::inline NLO_ISA::kernels
