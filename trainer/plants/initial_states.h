// SPDX-License-Identifier: MIT
// Initial states of simulated trajectories: the same on every platform, and different for training, validation and test
// under one seed.
//
// A stream is std::mt19937_64 (its numbers are fixed by the C++ standard) seeded with
//   splitmix64(seed + 0x9E3779B97F4A7C15 * (stream + 1))
// and read as follows; the standard library's distributions differ between platforms, so none is used:
//   u       = (r >> 11) * 2^-53 of the next 64 bits r, in [0, 1)
//   uniform = centre + half width (2u - 1) of the box
//   normal  = Marsaglia's polar method: v = 2u - 1 twice until 0 < q = v1^2 + v2^2 < 1, then v1 sqrt(-2 ln q / q); the
//             second of the two draws is dropped
//   circle  = centre + a cos phi + b sin phi, phi = 2 pi u: one u for a trajectory
//   list    = rounds of all states, each in a new order: Fisher and Yates from the last place down, place i exchanged
//             with place floor(u (i + 1))
// State by state within a trajectory, trajectory after trajectory: the first n do not depend on how many follow.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// The purpose of a set of trajectories or points. Evaluation uses kTest.
enum class SeedStream : std::uint64_t { kTraining = 0, kValidation = 1, kTest = 2, kCollocation = 3 };

/// Returns the seed of the engine for a stream.
std::uint64_t initial_state_seed(std::uint64_t seed, SeedStream stream);

/// Draws initial states, n_x x count, by config.initial_distribution. `box_scale` stretches the distribution about its
/// middle:
///   uniform   the box about its centre; a state with equal limits stays fixed
///   gaussian  the half widths, which are the standard deviations
///   circle    the half axes
///   list      each state about the mean of the list; a list of one state stays fixed
Eigen::MatrixXd draw_initial_states(const SimulationConfig& config, std::uint64_t engine_seed, Eigen::Index count,
                                    double box_scale = 1.0);

/// The smallest box around all initial states (gaussian: one standard deviation about the centre).
struct InitialBox {
  Eigen::VectorXd low, high;  ///< n_x each
};
InitialBox initial_box(const SimulationConfig& config);

/// Mean and covariance of the initial states, for Kalman filters.
struct InitialMoments {
  Eigen::VectorXd mean;        ///< n_x
  Eigen::MatrixXd covariance;  ///< n_x x n_x
};
InitialMoments initial_moments(const SimulationConfig& config);

}  // namespace nlo::trainer
