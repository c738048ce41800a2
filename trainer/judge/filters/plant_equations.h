// SPDX-License-Identifier: MIT
// A plant whose parameters are estimated beside its states.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/judge/filters/lane_plant.h"

namespace nlo::trainer {

/// Returns the plant with its state extended by these parameters, x = [x; p], p' = 0. If f and h are affine in p, which
/// is tested on states of `initial`, it uses differences of plants, which are then exact. Otherwise it evaluates
/// expressions, which takes longer.
LanePlant joint_plant(const PlantConfig& plant, const std::vector<std::string>& parameters,
                      const Eigen::MatrixXd& initial);

}  // namespace nlo::trainer
