// SPDX-License-Identifier: MIT
#include "trainer/experiments/forward_map.h"

#include "trainer/losses/registry.h"
#include "trainer/structures/table.h"

namespace nlo::trainer {

bool uses_forward_map(const Experiment& experiment) {
  return structure_of(experiment.observer).flies_forward_map() || needs_forward_map(experiment.loss);
}

}  // namespace nlo::trainer
