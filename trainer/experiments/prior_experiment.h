// SPDX-License-Identifier: MIT
// Makes the experiment that trains an observer with a prior (codegen/model/prior.h) from the identified plant, on the
// same logs.
#pragma once

#include <Eigen/Core>
#include <string>

#include "trainer/config/identification.h"

namespace nlo::trainer {

/// Returns the text of a checked draft: the plant with its identified parameters and the logs of the identification. A
/// recipe derives the rest, among it whether the filter alone is better than one with learned corrections. An angle
/// becomes its sine and cosine. An output that has the name of a state gets the name NAME_measured, and the state a
/// column with the same heading. A state that no column holds is stepped, and not estimated.
///   parameters  n_p, in the order of the plant's
///   directory   where the logs are; the training logs are read, because the bounds depend on them
/// Throws codegen::Error with the reason if the plant has no such observer: no column for any state, an angle that is
/// not in radians, a function without a derivative, a divisor whose bounds contain 0 on these logs.
std::string prior_experiment(const Identification& identification, const Eigen::VectorXd& parameters,
                             const std::string& directory);

}  // namespace nlo::trainer
