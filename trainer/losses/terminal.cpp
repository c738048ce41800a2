// SPDX-License-Identifier: MIT
#include "trainer/losses/state_error.h"
#include "trainer/losses/terms.h"

namespace nlo::trainer {

LossTerm terminal_loss() {
  return {.name = "terminal",
          .meaning = "weight of the terminal cost |x - x_hat|^2 at a segment's end",
          .needs_forward_map = false,
          .needs_eigenvalues = false,
          .needs_equations = false,
          .form = EstimateLoss{EstimateLoss::At::kSegmentEnds, add_state_error}};
}

}  // namespace nlo::trainer
