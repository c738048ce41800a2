// SPDX-License-Identifier: MIT
// Mean and standard deviation of each channel, over training trajectories and nothing else: scaling by what the test
// logs hold would leak them.
#pragma once

#include <Eigen/Core>

#include "trainer/data/dataset.h"

namespace nlo::trainer {

struct Scaling {
  Eigen::VectorXd mean;
  Eigen::VectorXd deviation;  ///< population standard deviation; 1 for a channel that never moves
};

/// Over all samples of all trajectories, which are at least one.
Scaling output_scaling(const Dataset& training);

/// Over the samples where the truth counts (Trajectory::weight).
Scaling state_scaling(const Dataset& training);

}  // namespace nlo::trainer
