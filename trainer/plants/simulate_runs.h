// SPDX-License-Identifier: MIT
// Simulated sets as an experiment describes them: each run with inputs of its own ([excitation]), with parameters of
// its own ([plant] parameters with a range) and with process noise ([simulation]). Where an experiment has none of
// these, it is simulate(), to the bit.
//
// Inputs are drawn at the samples and act between them as [observer] input_hold says, as in the loop and as an
// observer assumes:
//   zero_order   inputs(:,k) has acted since the sample before, over (t_{k-1}, t_k]
//   first_order  a ramp from inputs(:,k-1) to inputs(:,k)
// inputs(:,0) acted before the run began; under zero_order it has no effect.
#pragma once

#include <cstdint>

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/plants/excitation.h"
#include "trainer/plants/loop_estimator.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

/// The plant of one run: each parameter with a range drawn uniformly from it, by a stream of its own.
PlantConfig draw_parameters(const PlantConfig& plant, std::uint64_t engine_seed, std::uint64_t run);

/// `count` runs from drawn initial states (initial_states.h), by RK4 at the sample period; after each step process
/// noise adds N(0, sigma_i^2 h) to x_i.
///   experiment   has a [plant]
///   plant        make_plant() of it, by the nominal parameters
///   engine_seed  initial_state_seed(seed, stream): decides the initial states and all that is drawn
///   estimators   close the loop of [feedback]; null: the true state and the drawn error do
///   given        u(t) for all runs in place of [excitation]; null: as the experiment says
/// Runs in closed loop: drawn inputs are the references, inputs(:,k+1) = sat(k(x_hat_k, r_{k+1})), where x_hat_k knows
/// y_0 ... y_k and the inputs up to inputs(:,k); inputs(:,0) is the actuator at rest.
/// Throws codegen::Error when a run leaves the numbers, as simulate().
Dataset simulate_runs(const Experiment& experiment, const Plant& plant, std::uint64_t engine_seed, Eigen::Index count,
                      double box_scale = 1.0, const Excitation& given = {}, const LoopEstimators& estimators = {});

/// Ten times the farthest |x_i| of some runs as in training, n_x: an estimate beyond it is no state of the plant.
Eigen::VectorXd farthest_states(const Experiment& experiment);

}  // namespace nlo::trainer
