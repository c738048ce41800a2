// SPDX-License-Identifier: MIT
// What builds upon the steady state of a latent system: z settles at S y while y is constant. So z can start there; it
// can turn back with an angle by whole turns, as y - a and z - S a belong together; and what T* reads as z - S y does not
// depend on where the output rests. A model without a steady state (kHasSteadyState = false) has none of it.
#pragma once

#include "nlo/arithmetic.h"
#include "nlo/measurement.h"
#include "nlo/select.h"
#include "nlo/simd.h"

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

/// z <- z - S y for angles and for those outputs that T* knows through z - S y only: what the domain is a box of.
template <class Model, class Scalar, int kNz, int kNy>
constexpr void make_relative(const Model& model, const Scalar (&y)[kNy], Scalar (&z)[kNz]) {
  if constexpr (Model::kHasSteadyState) {
    for (int r = 0; r < kNz; ++r) {
      for (int j = 0; j < kNy; ++j) {
        if (!(model.outputs.wrap[j] > Scalar(0)) && !model.latent.relative[j]) continue;
        z[r] -= rounded<Scalar>(model.latent.steady_gain[r][j] * y[j]);
      }
    }
  }
}

/// Takes the whole turns off an angle that has left its first one, and S times as much off z: the latent system does not
/// notice, and z stays bounded however often a shaft turns.
template <Arithmetic kArithmetic, class Model, class Scalar, int kNz, int kNy>
constexpr void turn_back(const Model& model, Scalar (&y)[kNy], Scalar (&z)[kNz]) {
  if constexpr (Model::kHasSteadyState) {
    for (int j = 0; j < kNy; ++j) {
      const Scalar turn = model.outputs.wrap[j];
      if (!(turn > Scalar(0))) continue;
      const Scalar turns = OutputRange<Scalar, kNy>::template whole_turns<kArithmetic>(y[j], turn);
      const Scalar back = rounded<Scalar>(turn * turns);
      if (may_skip<kArithmetic>(back == Scalar(0))) continue;  // taking away 0 changes nothing: z is never -0
      y[j] -= back;
      for (int r = 0; r < kNz; ++r) z[r] -= rounded<Scalar>(model.latent.steady_gain[r][j] * back);
    }
  }
}

}  // namespace nlo
