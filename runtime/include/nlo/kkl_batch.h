// SPDX-License-Identifier: MIT
// Many plants of one KKL model, stepped together: sampled_batch.h, with the latent recurrence.
#pragma once

#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"
#include "nlo/latent.h"
#include "nlo/sampled_batch.h"

namespace nlo {

template <class Model, int kPlants, Arithmetic kArithmetic = Arithmetic::kFast>
class KklBatch : public SampledBatch<KklBatch<Model, kPlants, kArithmetic>, Model, kPlants, kArithmetic> {
  using Base = SampledBatch<KklBatch, Model, kPlants, kArithmetic>;
  friend Base;
  using Base::kNr;
  using typename Base::P;
  using typename Base::Rows;

 public:
  using Base::Base;
  using Base::kNz;

 private:
  template <int kTogether>
  void advance_block(const Rows& y, int first) {
    for (int v = first; v < first + kTogether; v += Base::kWidth) {
      P z[kNz], y_k[kNr], y_next[kNr];
      for (int r = 0; r < kNz; ++r) z[r] = simd::load<P>(&this->z_[r][v]);
      this->take(y, v, y_k, y_next);
      nlo::advance<Model::kPairs, kArithmetic>(this->model_->latent.step, z, y_k, y_next);
      for (int r = 0; r < kNz; ++r) this->keep(r, v, z[r]);
    }
  }
};

}  // namespace nlo
