// SPDX-License-Identifier: MIT
#include "trainer/structures/make_dynamics.h"

#include "trainer/structures/trainable_structure.h"

namespace nlo::trainer {

std::unique_ptr<LatentDynamics> make_dynamics(const Experiment& experiment, const ObserverStructure& structure,
                                              const std::vector<double>& steps_s, int threads) {
  return structure.module->latent_dynamics(experiment, structure, steps_s, threads);
}

std::unique_ptr<LatentDynamics> TrainableStructure::latent_dynamics(const Experiment& experiment,
                                                                    const ObserverStructure& structure,
                                                                    const std::vector<double>& steps_s,
                                                                    int threads) const {
  return std::make_unique<OdeLatent>([&] { return lanes(structure); }, threads, structure.latent,
                                     experiment.training.gradient, steps_s);
}

}  // namespace nlo::trainer
