// SPDX-License-Identifier: MIT
// Particle filter with complete knowledge: the plant with its true parameters and process noise, the distribution of
// initial states, and the distribution of the measurement noise, including bias and outliers. Its error is near the
// smallest error that any filter can have: the floor of a comparison.
//   x_i ~ runs' initial states;  each sample: x_i = Phi(x_i) (+ process noise),  w_i *= p(y | x_i)
// If fewer than half of the particles count, (sum w)^2 / sum w^2 < N / 2, they are resampled (systematic resampling)
// and spread by Liu and West's kernel, which keeps mean and covariance: x <- a x + (1 - a) mean + sqrt(1 - a^2) N(0,
// P). If one measurement alone would leave fewer, p(y | x) is applied as a product of several powers. A bias is one
// more state. Liu, West in: Doucet et al., Sequential Monte Carlo methods in practice, 2001, chapter 10.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "trainer/base/noise.h"
#include "trainer/config/experiment.h"
#include "trainer/judge/filters/lane_plant.h"

namespace nlo::trainer {

/// Returns the reason why the filter cannot be used: the noise has no likelihood, or there is no noise. Empty: it can
/// be used.
std::string no_likelihood(const NoiseConfig& noise);

/// Returns ln p(v) of a sensor's error without its bias, up to a constant. A hard edge is softened over 2 % of its
/// width.
Eigen::ArrayXd log_likelihood(const SensorNoise& noise, const Eigen::ArrayXd& v);

struct ParticleSettings {
  Eigen::Index particles = 400;  ///< three times as many if an output has a bias
  std::uint64_t seed = 1;
};

/// Returns the mean states (n_x x N) over one run.
///   runs        of one lane
///   simulation  initial states and process noise of the runs
Eigen::MatrixXd particle_estimates(const LanePlant& plant, const SimulationConfig& simulation, double box_scale,
                                   const NoiseConfig& noise, const LaneRuns& run, const ParticleSettings& settings,
                                   std::uint64_t run_number);

}  // namespace nlo::trainer
