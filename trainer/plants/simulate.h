// SPDX-License-Identifier: MIT
// Trajectories of a plant: classical Runge-Kutta of order 4 at the sample period, in double. An excitation u(t) is
// evaluated at the times of the stages, so that the method keeps its order.
#pragma once

#include <cstdint>

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/plants/excitation.h"
#include "trainer/plants/initial_states.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

/// Returns f(x, u), n_x x B for x n_x x B, with one u (n_u) for all columns; empty u: f(x).
Eigen::MatrixXd driven_derivative(const Plant& plant, const Eigen::MatrixXd& x, const Eigen::VectorXd& u);

/// Takes one RK4 step of length h from time_s for each column of x (n_x x B).
Eigen::MatrixXd rk4_step(const Plant& plant, const Eigen::MatrixXd& x, double h, const Excitation& excitation = {},
                         double time_s = 0.0);

/// Returns the first column of x that is beyond the useful range of any plant (|x| > 1e9 or NaN); -1 if there is none.
Eigen::Index first_escaped(const Eigen::MatrixXd& x);

/// Throws codegen::Error if a column of x has escaped, with the plant, the channel (a row of x), the initial state (a
/// column of `initial`) and the time.
void refuse_escape(const Plant& plant, const std::vector<codegen::Channel>& channels, const Eigen::MatrixXd& x,
                   const Eigen::MatrixXd& initial, double time_s);

/// Returns the number of samples of [0, horizon_s], both ends included: 2,501 for 50 s at 0.02 s.
Eigen::Index sample_count(const SimulationConfig& config);

/// Unwraps outputs that are angles (h may be an atan2), each trajectory from its first sample.
void unwrap_outputs(Dataset& dataset);

/// Returns `count` runs with their names and times, without inputs. States and outputs have their sizes but no values.
Dataset empty_runs(const Plant& plant, const SimulationConfig& config, Eigen::Index count);

/// Simulates noise-free trajectories from the columns of `initial` (n_x x count), all with the same excitation; u at
/// the samples is recorded. States and outputs are those of the plant (see PlantChannels), with angles unwrapped.
/// Throws codegen::Error with the plant, the initial state and the time if a trajectory overflows (|x| > 1e9 or NaN).
Dataset simulate_from(const Plant& plant, const SimulationConfig& config, const Eigen::MatrixXd& initial,
                      const Excitation& excitation = {});

/// Simulates from drawn initial states (see initial_states.h). The seed of the engine determines them:
/// initial_state_seed(seed, stream).
Dataset simulate(const Plant& plant, const SimulationConfig& config, std::uint64_t engine_seed, Eigen::Index count,
                 double box_scale = 1.0, const Excitation& excitation = {});

}  // namespace nlo::trainer
