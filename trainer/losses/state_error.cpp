// SPDX-License-Identifier: MIT
#include "trainer/losses/state_error.h"

#include "trainer/losses/terms.h"

namespace nlo::trainer {

void add_state_error(EstimateBlock& block, double share, bool backward, double& loss) {
  const float* weights = block.weights();
  for (std::size_t i = 0; i < block.states(); ++i) {
    loss += share * block.squares(i);
    if (!backward) continue;
    const float pull = 2.0F * block.per_unit(i) * static_cast<float>(share);
    const float* error = block.error(i);
    block.pull_back(i, [=](int s, float gain) { return pull * gain * weights[s] * error[s]; });
  }
}

LossTerm state_error_loss() {
  return {.name = "state_error",
          .meaning = "weight of the running cost |x - x_hat|^2 (12)",
          .needs_forward_map = false,
          .needs_eigenvalues = false,
          .needs_equations = false,
          .form = EstimateLoss{EstimateLoss::At::kSamples, add_state_error}};
}

}  // namespace nlo::trainer
