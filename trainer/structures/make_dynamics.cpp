// SPDX-License-Identifier: MIT
#include "trainer/structures/make_dynamics.h"

#include "trainer/structures/module.h"

namespace nlo::trainer {

std::unique_ptr<LatentDynamics> make_dynamics(const Experiment& experiment, const ObserverStructure& structure,
                                              const std::vector<double>& steps_s, int threads) {
  const LatentGradient gradient = experiment.training.gradient;
  const StructureModule& module = *structure.module;
  if (module.filters() && gradient == LatentGradient::kAutomatic) {
    return std::make_unique<LinearLatent>(structure.latent, structure.eigenvalues, steps_s,
                                          !experiment.observer.learn_eigenvalues);
  }
  return std::make_unique<OdeLatent>([&] { return module.lanes(structure); }, threads, structure.latent.hold, gradient,
                                     steps_s);
}

}  // namespace nlo::trainer
