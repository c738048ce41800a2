// SPDX-License-Identifier: MIT
#pragma once

#include "trainer/losses/estimate_block.h"

namespace nlo::trainer {

/// share sum_s w_s |x - x_hat|^2 over a block, each state in its unit or normalised.
void add_state_error(EstimateBlock& block, double share, bool backward, double& loss);

}  // namespace nlo::trainer
