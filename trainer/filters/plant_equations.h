// SPDX-License-Identifier: MIT
// Plants as expressions, the built-in ones too: to estimate a parameter beside the states, and to count what f costs.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/filters/lane_plant.h"

namespace nlo::trainer {

/// The same plant by expressions, with all of its parameters.
PlantConfig equations_of(const PlantConfig& plant);

/// The plant with its state extended by these parameters, x = [x; p], p' = 0. Where f and h are affine in p, which is
/// tried on states of `initial`, by differences of plants, which are exact then; else by expressions,
/// which take longer.
LanePlant joint_plant(const PlantConfig& plant, const std::vector<std::string>& parameters,
                      const Eigen::MatrixXd& initial);

}  // namespace nlo::trainer
