// SPDX-License-Identifier: MIT
// A plant whose parameters are estimated beside its states.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/judge/filters/lane_plant.h"

namespace nlo::trainer {

/// The plant with its state extended by these parameters, x = [x; p], p' = 0. Where f and h are affine in p, which is
/// tried on states of `initial`, by differences of plants, which are exact then; else by expressions,
/// which take longer.
LanePlant joint_plant(const PlantConfig& plant, const std::vector<std::string>& parameters,
                      const Eigen::MatrixXd& initial);

}  // namespace nlo::trainer
