// SPDX-License-Identifier: MIT
// Is this latent state inside what training has seen? A learned T* says nothing outside: an estimate from there is an
// extrapolation, and the loop should know.
#pragma once

#include "nlo/cxx20.h"

namespace nlo {

/// The box that the latent states of the training set filled, per coordinate. For angle outputs, and others
/// that T* knows only through z - S y, the latent is taken relative to its steady state S y, which does not change when
/// the angle turns or the output rests elsewhere.
template <class Scalar, int kNz>
struct Domain {
  Scalar latent_min[kNz];
  Scalar latent_max[kNz];

  constexpr bool contains(const Scalar (&z)[kNz]) const {
    // No && and no bool: as many instructions wherever z is, and vectors of them where there are any.
    int inside = 1;
    for (int r = 0; r < kNz; ++r) {
      inside &= static_cast<int>(z[r] >= latent_min[r]) & static_cast<int>(z[r] <= latent_max[r]);
    }
    return inside != 0;
  }
};

}  // namespace nlo
