// SPDX-License-Identifier: MIT
#include "trainer/learn/losses/estimate_block.h"
#include "trainer/learn/losses/terms.h"

namespace nlo::trainer {
namespace {

/// Adds share sum_s w_s |x - x_hat|^2 over a block. States are in their own units, or normalised.
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

}  // namespace

LossTerm state_error_loss() {
  return {.name = "state_error",
          .meaning = "weight of the running cost |x - x_hat|^2 (12)",
          .form = EstimateLoss{EstimateLoss::At::kSamples, add_state_error}};
}

LossTerm terminal_loss() {
  return {.name = "terminal",
          .meaning = "weight of the terminal cost |x - x_hat|^2 at a segment's end",
          .form = EstimateLoss{EstimateLoss::At::kSegmentEnds, add_state_error}};
}

}  // namespace nlo::trainer
