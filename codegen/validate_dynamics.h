// SPDX-License-Identifier: MIT
// The dynamics of each structure: what makes an observer forget its start, and stay stable when it is sampled.
#pragma once

#include "codegen/model.h"

namespace nlo::codegen {

/// D and F of a KKL observer, driven or not: D Hurwitz, and |A| < 1 at the sample period, in float too.
void check_linear_latent(const Model& model);

/// When an angle output turns once, z turns with it by S wrap; T* must not see that.
void check_turns(const Model& model);

/// Inputs, g(x) and T of a driven KKL observer.
void check_drive(const Model& model);

/// A, C, G and g_hat of (15): A - G C Hurwitz, and within the stable region of the Runge-Kutta method at the sample
/// period. What g_hat adds to it is not checked.
void check_luenberger(const Model& model);

}  // namespace nlo::codegen
