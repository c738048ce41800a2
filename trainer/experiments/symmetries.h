// SPDX-License-Identifier: MIT
// The symmetries of an experiment in one form: [training] mirror is one of the kind "sign".
#pragma once

#include <vector>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// What [training] mirror means: the signs of all channels but those declared even.
SymmetryConfig mirror_symmetry(const Experiment& experiment);

/// Those that training takes images by: mirror, and those declared that no structure has by construction.
std::vector<SymmetryConfig> symmetries_of(const Experiment& experiment);

}  // namespace nlo::trainer
