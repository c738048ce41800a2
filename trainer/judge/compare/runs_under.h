// SPDX-License-Identifier: MIT
// Runs of an experiment's plant under a condition, for evaluate, report and sweep.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/judge/compare/conditions.h"
#include "trainer/plants/loop_estimator.h"

namespace nlo::trainer {

/// Returns the experiment with `changes` (--set). Throws codegen::Error for a key that does not exist or is not in
/// [plant], [simulation], [excitation] or [feedback].
Experiment changed_experiment(const Experiment& experiment, const std::vector<std::string>& changes);

/// Returns an experiment without the random values of its training: nominal parameters, no process noise.
Experiment nominal_experiment(const Experiment& experiment);

/// Returns the condition "as_trained": sensors with `noise`, and the process noise of the training in all runs.
Condition trained_condition(const Experiment& experiment, const NoiseConfig& noise);

/// Returns `base`, which already has the condition's `changes`, with the parameters and the process noise of the
/// condition in run `run`, counted over all seeds.
Experiment experiment_under(const Experiment& base, const Condition& condition, std::size_t run);

/// Makes `count` runs, the first of them number `first_run`, with the plant's own states and outputs and its true
/// inputs. Plants with the same parameters are simulated together; each run has the same start and inputs as in the
/// whole set.
///   base         already has the condition's `changes`
///   engine_seed  initial_state_seed(seed, stream)
///   estimators   close the loop of [feedback]; null: the loop reads the true state
Dataset runs_under(const Experiment& base, const Condition& condition, std::uint64_t engine_seed, int count,
                   std::size_t first_run = 0, const LoopEstimators& estimators = {});

/// Replaces the inputs of runs by those that estimators get. A value that does not arrive is held, as in flight.
void disturb_inputs(const NoiseConfig& noise, std::uint64_t seed, Dataset& runs);

/// Returns true if inputs are constant between samples. u(t) of a condition is smooth; random inputs may be held.
bool holds_inputs(const Experiment& base, const Condition& condition);

/// Makes runs like those of the training, as channels, for estimators that learn without a plant.
Dataset fresh_training_runs(const Experiment& experiment, const NoiseConfig& input_noise);

/// Returns the seed of their noise, which differs from the noise of the test sets.
std::uint64_t fresh_noise_seed(const Experiment& experiment);

}  // namespace nlo::trainer
