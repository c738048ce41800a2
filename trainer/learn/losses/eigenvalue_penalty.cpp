// SPDX-License-Identifier: MIT
#include "trainer/learn/losses/terms.h"

namespace nlo::trainer {
namespace {

double add_penalty(double share, double lambda, double& loss) {
  loss += share * lambda * lambda;
  return 2.0 * share * lambda;
}

}  // namespace

LossTerm eigenvalue_penalty_loss() {
  return {.name = "eigenvalue_penalty",
          .meaning = "weight gamma of the eigenvalue penalty gamma |lambda|^2 (20)",
          .needs_eigenvalues = true,
          .form = EigenvalueLoss{add_penalty}};
}

}  // namespace nlo::trainer
