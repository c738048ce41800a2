// SPDX-License-Identifier: MIT
// What builds upon the steady state of a latent system: z settles at S y while y is constant. So z can start there;
// when an angle goes back by whole turns a, z goes back by S a; and z - S y does not depend on where the output rests.
// Nothing happens in a model without a steady state (kHasSteadyState = false).
#pragma once

#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"
#include "nlo/measurement.h"

namespace nlo {

/// The first measurement sets z to its steady state.
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

/// rest <- rest + S y, for angles and for those outputs that T* knows only through z - S y. The domain is a box of what
/// is left of z.
template <class Model, class Scalar, int kNz, int kNy>
constexpr void add_relative_state(const Model& model, const Scalar (&y)[kNy], Scalar (&rest)[kNz]) {
  if constexpr (Model::kHasSteadyState) {
    for (int j = 0; j < kNy; ++j) {
      if (!(model.outputs.wrap[j] > Scalar(0)) && !model.latent.relative[j]) continue;
      for (int r = 0; r < kNz; ++r) rest[r] += rounded<Scalar>(model.latent.steady_gain[r][j] * y[j]);
    }
  }
}

/// An angle, or another output that wraps, goes back by whole turns once it has left its first, and z by S times as
/// much: the latent system does not notice. This keeps z bounded however often the shaft turns.
template <Arithmetic kArithmetic, class Model, class Scalar, int kNz, int kNy>
constexpr void turn_back(const Model& model, Scalar (&y)[kNy], Scalar (&z)[kNz]) {
  if constexpr (Model::kHasSteadyState) {
    for (int j = 0; j < kNy; ++j) {
      const Scalar turn = model.outputs.wrap[j];
      if (!(turn > Scalar(0))) continue;
      const Scalar turns = ReadingRange<Scalar, kNy>::template whole_turns<kArithmetic>(y[j], turn);
      const Scalar back = rounded<Scalar>(turn * turns);
      if (may_skip<kArithmetic>(back == Scalar(0))) continue;  // taking away 0 changes nothing: z is never -0
      y[j] -= back;
      for (int r = 0; r < kNz; ++r) z[r] -= rounded<Scalar>(model.latent.steady_gain[r][j] * back);
    }
  }
}

}  // namespace nlo
