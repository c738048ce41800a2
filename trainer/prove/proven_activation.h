// SPDX-License-Identifier: MIT
// Bounds of the difference between the runtime's activations and the real functions, over all floats.
// tests/proofs/gappa.py reads these numbers and proves them from the constants in nlo/kernels/activation.h, for the
// order of operations of the deterministic policy and of C99. The fast policy may fuse a product and a sum; for it,
// tests over every float show that the error is at most kTanhMaxError, which is less.
#pragma once

#include <nlo/kernels/activation.h>

namespace nlo::trainer {

/// Bound of |tanh_rational - tanh|.
inline constexpr double kProvenTanh = 1e-6;
inline constexpr double kProvenTanh5e6 = 5e-6;
inline constexpr double kProvenTanh5e5 = 5e-5;
inline constexpr double kProvenTanhDouble = 4e-15;
static_assert(kTanhMaxError <= kProvenTanh && kTanh5e6MaxError <= kProvenTanh5e6 &&
              kTanh5e5MaxError <= kProvenTanh5e5 && kTanhMaxErrorDouble <= kProvenTanhDouble);

/// Bound of |(1 + tanh_rational) / 2 - (1 + tanh) / 2| in float.
inline constexpr double kProvenGate = 0.5 * kProvenTanh + 0x1p-24;

/// Bound of the error of converting a float within +-32767 to an int16 input.
inline constexpr double kProvenInt16Input = 0.5 + 0x1p-9;

}  // namespace nlo::trainer
