// SPDX-License-Identifier: MIT
// Functions of the steady state: z settles at S y while y is constant. From this follow
// - the start of z at S y,
// - the unwrapping of angles: if y is reduced by whole turns a, z is reduced by S a,
// - the relative latent z - S y, which does not change if a constant is added to y.
// In a model without a steady state (kHasSteadyState = false) these functions do nothing.
#pragma once

#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"
#include "nlo/measurement.h"

namespace nlo::inline NLO_ISA {

/// Returns true if the first measurement sets z to its steady state.
template <class Model>
constexpr bool starts_steady(const Model& model) {
  if constexpr (Model::kHasSteadyState) {
    return model.latent.starts_steady;
  } else {
    return false;
  }
}

/// z <- z + S y.
template <class Model, class Scalar, int kNz, int kNy>
constexpr void add_steady_state(const Model& model, const Scalar (&y)[kNy], Scalar (&z)[kNz]) {
  if constexpr (Model::kHasSteadyState) {
    for (int r = 0; r < kNz; ++r) {
      for (int j = 0; j < kNy; ++j) z[r] += rounded<Scalar>(model.latent.steady_gain[r][j] * y[j]);
    }
  }
}

/// rest <- rest + S y over the outputs that T* reads only through z - S y, such as angles. The domain is a box of
/// z - rest.
template <class Model, class Scalar, int kNz, int kNy>
constexpr void add_relative_state(const Model& model, const Scalar (&y)[kNy], Scalar (&rest)[kNz]) {
  if constexpr (Model::kHasSteadyState) {
    for (int j = 0; j < kNy; ++j) {
      if (!(model.outputs.wrap[j] > Scalar(0)) && !model.latent.relative[j]) continue;
      for (int r = 0; r < kNz; ++r) rest[r] += rounded<Scalar>(model.latent.steady_gain[r][j] * y[j]);
    }
  }
}

/// Reduces every output that wraps by its whole turns a, and z by S a. The latent system is invariant to this. z stays
/// bounded however often a shaft turns.
template <Arithmetic kArithmetic, class Model, class Scalar, int kNz, int kNy>
constexpr void turn_back(const Model& model, Scalar (&y)[kNy], Scalar (&z)[kNz]) {
  if constexpr (Model::kHasSteadyState) {
    for (int j = 0; j < kNy; ++j) {
      const Scalar turn = model.outputs.wrap[j];
      if (!(turn > Scalar(0))) continue;
      const Scalar turns = ReadingRange<Scalar, kNy>::template whole_turns<kArithmetic>(y[j], turn);
      const Scalar back = rounded<Scalar>(turn * turns);
      if (may_skip<kArithmetic>(back == Scalar(0))) continue;  // subtracting 0 changes nothing, because z is never -0
      y[j] -= back;
      for (int r = 0; r < kNz; ++r) z[r] -= rounded<Scalar>(model.latent.steady_gain[r][j] * back);
    }
  }
}

}  // namespace nlo::inline NLO_ISA
