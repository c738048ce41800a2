// SPDX-License-Identifier: MIT
// Many plants with one gated model, stepped together (sampled_batch.h). kernels/per_isa/gated.inc computes the gates as
// [unit][plant].
#pragma once

#include "nlo/gate.h"
#include "nlo/gated_observer.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/batch.h"
#include "nlo/kernels/simd.h"
#include "nlo/mlp.h"
#include "nlo/sampled_batch.h"

namespace nlo::inline NLO_ISA::kernels {

#if NLO_HAS_VECTORS
namespace native {
#define NLO_CODE NLO_INLINE
#include "nlo/kernels/per_isa/gated_plants.inc"
#undef NLO_CODE
}  // namespace native
#endif

#if defined(NLO_DISPATCHES)
namespace x86 {

namespace avx2 {
#define NLO_CODE NLO_CODE_AVX2
#include "nlo/kernels/per_isa/gated_plants.inc"
#undef NLO_CODE
}  // namespace avx2

namespace avx512 {
#define NLO_CODE NLO_CODE_AVX512
#include "nlo/kernels/per_isa/gated_plants.inc"
#undef NLO_CODE
}  // namespace avx512

template <Arithmetic kArithmetic, int kPlants, class Model, class Rows, class Scalar, int kNz, int kNr, int kStride>
__attribute__((noinline, NLO_TARGET_AVX2)) bool gated_plants_avx2(const Model& model, const Rows& y, int first,
                                                                  Scalar (&z)[kNz][kStride],
                                                                  Scalar (&kept)[kNr][kStride]) {
  return avx2::gated_plants<kArithmetic, kPlants>(model, y, first, z, kept);
}

template <Arithmetic kArithmetic, int kPlants, class Model, class Rows, class Scalar, int kNz, int kNr, int kStride>
__attribute__((noinline, NLO_TARGET_AVX512)) bool gated_plants_avx512(const Model& model, const Rows& y, int first,
                                                                      Scalar (&z)[kNz][kStride],
                                                                      Scalar (&kept)[kNr][kStride]) {
  return avx512::gated_plants<kArithmetic, kPlants>(model, y, first, z, kept);
}

}  // namespace x86
#endif

#if NLO_HAS_VECTORS
/// Steps a block of kPlants plants; for_batch_block() chooses its size. See gated_plants() of gated_plants.inc.
template <Arithmetic kArithmetic, int kPlants, class Model, class Rows, class Scalar, int kNz, int kNr, int kStride>
NLO_INLINE bool gated_plants(const Model& model, const Rows& y, int first, Scalar (&z)[kNz][kStride],
                             Scalar (&kept)[kNr][kStride]) {
#if defined(NLO_DISPATCHES)
  const x86::Level level = x86::level();
  if constexpr (kPlants == kBatchBlock<Scalar, 64>) {
    if (x86::has_avx512(level)) return x86::gated_plants_avx512<kArithmetic, kPlants>(model, y, first, z, kept);
  }
  if constexpr (kPlants == kBatchBlock<Scalar, 32>) {
    if (level == x86::Level::kAvx2) return x86::gated_plants_avx2<kArithmetic, kPlants>(model, y, first, z, kept);
  }
#endif
  if constexpr (kPlants == kBatchBlock<Scalar, NLO_NATIVE_BYTES>)
    return native::gated_plants<kArithmetic, kPlants>(model, y, first, z, kept);
  return false;
}
#endif

}  // namespace nlo::inline NLO_ISA::kernels

namespace nlo::inline NLO_ISA {

template <class Model, int kPlants, Arithmetic kArithmetic = Arithmetic::kFast>
class GatedBatch : public SampledBatch<GatedBatch<Model, kPlants, kArithmetic>, Model, kPlants, kArithmetic> {
  using Base = SampledBatch<GatedBatch, Model, kPlants, kArithmetic>;
  friend Base;
  using typename Base::Rows;

 public:
  using Base::Base;

 private:
  template <int kTogether>
  bool advance_block([[maybe_unused]] const Rows& y, [[maybe_unused]] int first) {
#if NLO_HAS_VECTORS
    return kernels::gated_plants<kArithmetic, kTogether>(*this->model_, y, first, this->z_, this->y_);
#else
    return false;  // the caller steps the plants one by one
#endif
  }
};

}  // namespace nlo::inline NLO_ISA
