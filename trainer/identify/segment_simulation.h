// SPDX-License-Identifier: MIT
// Simulates a segment of a log from a given state with given parameters, and compares it with the measurements.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "trainer/config/identification.h"
#include "trainer/data/dataset.h"
#include "trainer/plants/parametric_plant.h"

namespace nlo::trainer {

struct FittedChannel;

/// Returns x after `h` seconds by RK4 in steps of at most `longest_step_s` (0: one step); u is a ramp from u0 to u1.
Eigen::VectorXd simulate_step(ParametricPlant& plant, Eigen::VectorXd x, double h, const Eigen::VectorXd& u0,
                              const Eigen::VectorXd& u1, double longest_step_s);

class SegmentSimulation {
 public:
  /// `input_rows`: row of each plant input among the inputs of the logs. `channels` must outlive this object.
  SegmentSimulation(const Identification& identification, const std::vector<FittedChannel>& channels,
                    const std::vector<Eigen::Index>& input_rows);

  /// Returns (measured - simulated) / deviation of each channel, sample by sample, channels x samples in columns; 0 if
  /// the truth is masked. Steps follow the time stamps.
  ///   x0  n_x, at sample `first`
  Eigen::VectorXd residuals(const Trajectory& run, Eigen::Index first, Eigen::Index samples, const Eigen::VectorXd& p,
                            const Eigen::VectorXd& x0);

 private:
  Eigen::VectorXd inputs_at(const Trajectory& run, Eigen::Index sample) const;

  const IdentifyConfig& config_;
  const std::vector<FittedChannel>& channels_;
  std::vector<Eigen::Index> input_rows_;
  ParametricPlant plant_;
};

}  // namespace nlo::trainer
