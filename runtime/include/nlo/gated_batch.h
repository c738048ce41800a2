// SPDX-License-Identifier: MIT
// Many plants of one gated model, stepped together: sampled_batch.h, with the gates of kernels/per_isa/gated.inc over
// [unit][plant].
#pragma once

#include "nlo/gate.h"
#include "nlo/gated_observer.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/batch.h"
#include "nlo/kernels/simd.h"
#include "nlo/mlp.h"
#include "nlo/sampled_batch.h"

namespace nlo::kernels {

#if defined(NLO_DISPATCHES)
namespace x86 {

template <Arithmetic kArithmetic, int kPlants, int kNz, class Gates, class Candidate, class Scalar>
__attribute__((noinline, NLO_TARGET_AVX2)) void gated_batch_avx2(const Gates& gates, const Candidate& candidate,
                                                                 Scalar* in, Scalar* gate, Scalar* target, Scalar* z) {
  avx2::gated_units<kArithmetic, true, avx2::PlantsBeside<kPlants>, kNz>(gates, candidate, in, gate, target, z,
                                                                         Scalar(1));
}

template <Arithmetic kArithmetic, int kPlants, int kNz, class Gates, class Candidate, class Scalar>
__attribute__((noinline, NLO_TARGET_AVX512)) void gated_batch_avx512(const Gates& gates, const Candidate& candidate,
                                                                     Scalar* in, Scalar* gate, Scalar* target,
                                                                     Scalar* z) {
  avx512::gated_units<kArithmetic, true, avx512::PlantsBeside<kPlants>, kNz>(gates, candidate, in, gate, target, z,
                                                                             Scalar(1));
}

}  // namespace x86
#endif

/// A step of one sample period of kPlants plants, [unit][plant], as for_batch_block() has chosen; see gated_units().
template <Arithmetic kArithmetic, int kPlants, int kNz, class Gates, class Candidate, class Scalar>
NLO_INLINE void gated_batch(const Gates& gates, const Candidate& candidate, Scalar* in, Scalar* gate, Scalar* target,
                            Scalar* z) {
#if defined(NLO_DISPATCHES)
  const x86::Level level = x86::level();
  if constexpr (kPlants == kBatchBlock<Scalar, 64>) {
    if (x86::has_avx512(level))
      return x86::gated_batch_avx512<kArithmetic, kPlants, kNz>(gates, candidate, in, gate, target, z);
  }
  if constexpr (kPlants == kBatchBlock<Scalar, 32>) {
    if (level == x86::Level::kAvx2)
      return x86::gated_batch_avx2<kArithmetic, kPlants, kNz>(gates, candidate, in, gate, target, z);
  }
#endif
#if NLO_HAS_VECTORS
  if constexpr (kPlants == kBatchBlock<Scalar, NLO_NATIVE_BYTES>)
    gated_units<kArithmetic, true, native::PlantsBeside<kPlants>, kNz>(gates, candidate, in, gate, target, z,
                                                                       Scalar(1));
#else
  for (int n = 0; n < kPlants; ++n) {
    LayerBuffer<Scalar, Gates::kIn> own_in;
    Scalar own_z[kNz];
    for (int i = 0; i < Gates::kIn; ++i) own_in.values[i] = in[i * kPlants + n];
    for (int r = 0; r < kNz; ++r) own_z[r] = z[r * kPlants + n];
    gated_step<kArithmetic, true>(gates, candidate, own_in.values, gate, target, own_z, Scalar(1));
    for (int r = 0; r < kNz; ++r) z[r * kPlants + n] = own_z[r];
  }
#endif
}

}  // namespace nlo::kernels

namespace nlo {

template <class Model, int kPlants, Arithmetic kArithmetic = Arithmetic::kFast>
class GatedBatch : public SampledBatch<GatedBatch<Model, kPlants, kArithmetic>, Model, kPlants, kArithmetic> {
  using Base = SampledBatch<GatedBatch, Model, kPlants, kArithmetic>;
  friend Base;
  using Base::kNr;
  using Base::kWidth;
  using typename Base::P;
  using typename Base::Rows;

 public:
  using Base::Base;
  using Base::kNz;
  using typename Base::Scalar;

 private:
  template <int kTogether>
  void advance_block(const Rows& y, int first) {
    alignas(Base::kAlignment) Scalar in[(kNz + kNr) * kTogether], z[kNz * kTogether];
    alignas(Base::kAlignment) Scalar gate[2 * kNz * kTogether], target[kNz * kTogether];
    for (int v = 0; v < kTogether; v += kWidth) {
      P y_k[kNr], y_next[kNr];
      this->take(y, first + v, y_k, y_next);
      for (int r = 0; r < kNz; ++r) {
        const P own = simd::load<P>(&this->z_[r][first + v]);
        simd::store(&in[r * kTogether + v], own);
        simd::store(&z[r * kTogether + v], own);
      }
      for (int j = 0; j < kNr; ++j) simd::store(&in[(kNz + j) * kTogether + v], y_next[j]);
    }
    kernels::gated_batch<kArithmetic, kTogether, kNz>(this->model_->gates.mlp.layer, this->model_->candidate.mlp.layer,
                                                      in, gate, target, z);
    for (int r = 0; r < kNz; ++r) {
      for (int v = 0; v < kTogether; v += kWidth) this->keep(r, first + v, simd::load<P>(&z[r * kTogether + v]));
    }
  }
};

}  // namespace nlo
