// SPDX-License-Identifier: MIT
#include "trainer/learn/losses/loss_registry.h"

#include <algorithm>

#include "trainer/learn/losses/terms.h"

namespace nlo::trainer {

const std::vector<LossTerm>& loss_terms() {
  static const std::vector<LossTerm> kTerms = {state_error_loss(),     terminal_loss(),       eigenvalue_penalty_loss(),
                                               map_consistency_loss(), reconstruction_loss(), pde_residual_loss()};
  return kTerms;
}

bool needs_forward_map(const LossConfig& config) {
  return std::ranges::any_of(
      loss_terms(), [&](const LossTerm& term) { return term.needs_forward_map && config.weight(term.name) > 0.0; });
}

bool needs_equations(const LossConfig& config) {
  return std::ranges::any_of(
      loss_terms(), [&](const LossTerm& term) { return term.needs_equations && config.weight(term.name) > 0.0; });
}

}  // namespace nlo::trainer
