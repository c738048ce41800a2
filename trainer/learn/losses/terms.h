// SPDX-License-Identifier: MIT
// The entries that loss_registry.cpp lists. Each one is defined in the file of its name; terminal_loss is in
// state_error.cpp.
#pragma once

#include "trainer/learn/losses/loss_registry.h"

namespace nlo::trainer {

LossTerm state_error_loss();         ///< |x - x_hat|^2 along the segments (12)
LossTerm terminal_loss();            ///< |x - x_hat|^2 at their ends
LossTerm eigenvalue_penalty_loss();  ///< |lambda|^2 (20)
LossTerm map_consistency_loss();     ///< |z - T(x)|^2
LossTerm reconstruction_loss();      ///< |x - T*(T(x))|^2
LossTerm pde_residual_loss();        ///< |dT/dx f(x) - D T(x) - F h(x)|^2 (5)

}  // namespace nlo::trainer
