// SPDX-License-Identifier: MIT
#include "trainer/structures/make_dynamics.h"

#include <algorithm>

#include "trainer/structures/general_dynamics.h"
#include "trainer/structures/kkl_dynamics.h"
#include "trainer/structures/luenberger_dynamics.h"

namespace nlo::trainer {

template <class Scalar>
std::unique_ptr<OdeDynamics<Scalar>> make_ode_dynamics(const ObserverStructure& structure) {
  const DynamicsNetwork& network = structure.dynamics;
  switch (structure.kind) {
    case StructureKind::kLuenberger:
      return std::make_unique<LuenbergerDynamics<Scalar>>(structure.known, network.shape, network.inputs);
    case StructureKind::kGeneral:
      return std::make_unique<GeneralDynamics<Scalar>>(structure.outputs, network.shape, network.inputs);
    case StructureKind::kKkl:
    case StructureKind::kDrivenKkl:
      break;
  }
  return std::make_unique<KklDynamics<Scalar>>(structure.latent, structure.eigenvalues, structure.outputs);
}

template std::unique_ptr<OdeDynamics<float>> make_ode_dynamics(const ObserverStructure&);
template std::unique_ptr<OdeDynamics<double>> make_ode_dynamics(const ObserverStructure&);

std::unique_ptr<LatentDynamics> make_dynamics(const Experiment& experiment, const ObserverStructure& structure,
                                              const std::vector<double>& steps_s, int threads) {
  const std::string& gradient = experiment.training.gradient;
  if (structure.is_kkl() && gradient == "automatic") {
    return std::make_unique<LinearLatent>(structure.latent, structure.eigenvalues, steps_s,
                                          !experiment.observer.learn_eigenvalues);
  }
  return std::make_unique<OdeLatent>([&] { return make_ode_dynamics<float>(structure); }, threads,
                                     structure.latent.hold, gradient, steps_s);
}

}  // namespace nlo::trainer
