// SPDX-License-Identifier: MIT
// How far the runtime's activations are from the real functions at most, over all floats: theorems that
// tests/proofs/gappa.py proves of the constants in nlo/kernels/activation.h, in the order of the deterministic policy
// and of C99. It reads the numbers here. The fast policy may join a product and a sum: of it, tests over every float
// say kTanhMaxError, which is less.
#pragma once

#include <nlo/kernels/activation.h>

namespace nlo::trainer {

/// |tanh_rational - tanh|.
inline constexpr double kProvenTanh = 1e-6;
inline constexpr double kProvenTanh5e6 = 5e-6;
inline constexpr double kProvenTanh5e5 = 5e-5;
inline constexpr double kProvenTanhDouble = 4e-15;
static_assert(kTanhMaxError <= kProvenTanh && kTanh5e6MaxError <= kProvenTanh5e6 &&
              kTanh5e5MaxError <= kProvenTanh5e5 && kTanhMaxErrorDouble <= kProvenTanhDouble);

/// |(1 + tanh_rational) / 2 - (1 + tanh) / 2| in float.
inline constexpr double kProvenGate = 0.5 * kProvenTanh + 0x1p-24;

/// An int16 input: from a float within +-32767 to its integer.
inline constexpr double kProvenInt16Input = 0.5 + 0x1p-9;

}  // namespace nlo::trainer
