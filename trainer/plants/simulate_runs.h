// SPDX-License-Identifier: MIT
// Simulated sets of an experiment. Each run has its own inputs ([excitation]), its own parameters ([plant] parameters
// with a range) and process noise ([simulation]). For an experiment with none of these the result equals simulate() bit
// for bit.
//
// Inputs are drawn at the samples. Between samples they act as [observer] input_hold defines, both in the loop and in
// the equations of the observer:
//   zero_order   inputs(:,k) has acted since the sample before, over (t_{k-1}, t_k]
//   first_order  a ramp from inputs(:,k-1) to inputs(:,k)
// inputs(:,0) acted before the run began; with zero_order it has no effect.
#pragma once

#include <cstdint>

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/plants/excitation.h"
#include "trainer/plants/loop_estimator.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

/// Draws the plant of one run: each parameter with a range is uniform in it, with a stream of its own.
PlantConfig draw_parameters(const PlantConfig& plant, std::uint64_t engine_seed, std::uint64_t run);

/// Simulates `count` runs from drawn initial states (initial_states.h), by RK4 at the sample period. After each step
/// process noise adds N(0, sigma_i^2 h) to x_i, in the runs of SimulationConfig::has_process_noise().
///   experiment   has a [plant]
///   plant        its make_plant(), with the nominal parameters
///   engine_seed  initial_state_seed(seed, stream): determines the initial states and all other draws
///   estimators   close the loop of [feedback]; null: the loop reads the true state and the drawn error
///   given        u(t) for all runs instead of [excitation]; null: by the experiment
/// In runs in closed loop the drawn inputs are the references: inputs(:,k+1) = sat(k(x_hat_k, r_{k+1})), where x_hat_k
/// knows y_0 ... y_k and the inputs up to inputs(:,k). inputs(:,0) is the input of the actuator at rest. Throws
/// codegen::Error if a run overflows, like simulate().
Dataset simulate_runs(const Experiment& experiment, const Plant& plant, std::uint64_t engine_seed, Eigen::Index count,
                      double box_scale = 1.0, const Excitation& given = {}, const LoopEstimators& estimators = {});

/// Returns ten times the largest |x_i| of some runs like those of training, n_x. The plant does not reach states beyond
/// it.
Eigen::VectorXd farthest_states(const Experiment& experiment);

}  // namespace nlo::trainer
