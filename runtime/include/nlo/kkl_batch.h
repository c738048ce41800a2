// SPDX-License-Identifier: MIT
// Many plants with one KKL model, stepped together (sampled_batch.h).
#pragma once

#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/batch.h"
#include "nlo/sampled_batch.h"

namespace nlo::inline NLO_ISA::kernels {

#if defined(NLO_DISPATCHES)
namespace x86 {

template <Arithmetic kArithmetic, int kPlants, class Model, class Rows, class Scalar, int kNz, int kNr, int kStride>
__attribute__((noinline, NLO_TARGET_AVX2)) bool kkl_plants_avx2(const Model& model, const Rows& y, int first,
                                                                Scalar (&z)[kNz][kStride],
                                                                Scalar (&kept)[kNr][kStride]) {
  return avx2::kkl_plants<kArithmetic, kPlants>(model, y, first, z, kept);
}

template <Arithmetic kArithmetic, int kPlants, class Model, class Rows, class Scalar, int kNz, int kNr, int kStride>
__attribute__((noinline, NLO_TARGET_AVX512)) bool kkl_plants_avx512(const Model& model, const Rows& y, int first,
                                                                    Scalar (&z)[kNz][kStride],
                                                                    Scalar (&kept)[kNr][kStride]) {
  return avx512::kkl_plants<kArithmetic, kPlants>(model, y, first, z, kept);
}

}  // namespace x86
#endif

/// Steps a block of kPlants plants; for_batch_block() chooses its size. See kkl_plants() of plants.inc.
template <Arithmetic kArithmetic, int kPlants, class Model, class Rows, class Scalar, int kNz, int kNr, int kStride>
NLO_INLINE bool kkl_plants(const Model& model, const Rows& y, int first, Scalar (&z)[kNz][kStride],
                           Scalar (&kept)[kNr][kStride]) {
#if defined(NLO_DISPATCHES)
  const x86::Level level = x86::level();
  if constexpr (kPlants == kBatchBlock<Scalar, 64>) {
    if (x86::has_avx512(level)) return x86::kkl_plants_avx512<kArithmetic, kPlants>(model, y, first, z, kept);
  }
  if constexpr (kPlants == kBatchBlock<Scalar, 32>) {
    if (level == x86::Level::kAvx2) return x86::kkl_plants_avx2<kArithmetic, kPlants>(model, y, first, z, kept);
  }
#endif

  if constexpr (kPlants == kBatchBlock<Scalar, NLO_NATIVE_BYTES>)
    return native::kkl_plants<kArithmetic, kPlants>(model, y, first, z, kept);

  return false;
}

}  // namespace nlo::inline NLO_ISA::kernels

namespace nlo::inline NLO_ISA {

template <class Model, int kPlants, Arithmetic kArithmetic = Arithmetic::kFast>
class KklBatch : public SampledBatch<KklBatch<Model, kPlants, kArithmetic>, Model, kPlants, kArithmetic> {
  using Base = SampledBatch<KklBatch, Model, kPlants, kArithmetic>;
  friend Base;
  using typename Base::Rows;

 public:
  using Base::Base;

 private:
  template <int kTogether>
  bool advance_block(const Rows& y, int first) {
    return kernels::kkl_plants<kArithmetic, kTogether>(*this->model_, y, first, this->z_, this->y_);
  }
};

}  // namespace nlo::inline NLO_ISA
