// SPDX-License-Identifier: MIT
// Many plants of one gated model, stepped together: sampled_batch.h, with the gates of kernels/per_isa/gated.inc over
// [unit][plant].
#pragma once

#include "nlo/gate.h"
#include "nlo/gated_observer.h"
#include "nlo/kernels/activation.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"
#include "nlo/mlp_batch.h"
#include "nlo/sampled_batch.h"

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
    const auto tanh = [](P a) { return tanh_rational<Activation::kTanh, kArithmetic>(a); };
    alignas(Base::kAlignment) Scalar in[(kNz + kNr) * kTogether], gate[2 * kNz * kTogether], target[kNz * kTogether];
    for (int v = 0; v < kTogether; v += kWidth) {
      P y_k[kNr], y_next[kNr];
      this->take(y, first + v, y_k, y_next);
      for (int r = 0; r < kNz; ++r) simd::store(&in[r * kTogether + v], simd::load<P>(&this->z_[r][first + v]));
      for (int j = 0; j < kNr; ++j) simd::store(&in[(kNz + j) * kTogether + v], y_next[j]);
    }
    evaluate_batch<kArithmetic, kTogether>(this->model_->gates.mlp, in, gate);
    for (int at = 0; at < kNz * kTogether; at += kWidth) {
      const P reset = gate_of<kArithmetic>(tanh(simd::load<P>(&gate[kNz * kTogether + at])));
      simd::store(&in[at], simd::load<P>(&in[at]) * reset);
    }
    evaluate_batch<kArithmetic, kTogether>(this->model_->candidate.mlp, in, target);
    for (int r = 0; r < kNz; ++r) {
      for (int v = 0; v < kTogether; v += kWidth) {
        const int at = r * kTogether + v;
        const P z = simd::load<P>(&this->z_[r][first + v]);
        const P share = gate_of<kArithmetic>(tanh(simd::load<P>(&gate[at])));
        this->keep(r, first + v, multiply_add<kArithmetic, P>(share, tanh(simd::load<P>(&target[at])) - z, z));
      }
    }
  }
};

}  // namespace nlo
