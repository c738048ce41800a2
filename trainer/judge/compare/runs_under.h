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

/// The experiment with `changes` (--set). Throws codegen::Error for a key that does not exist, or that is no key of
/// [plant], [simulation], [excitation] or [feedback].
Experiment changed_experiment(const Experiment& experiment, const std::vector<std::string>& changes);

/// An experiment without the random values of its training: nominal parameters, no process noise.
Experiment nominal_experiment(const Experiment& experiment);

/// The condition "as_trained": sensors with `noise`, and the process noise of the training.
Condition trained_condition(const Experiment& experiment, const NoiseConfig& noise);

/// `base`, in which the condition's `changes` are made already, with its parameters and its process noise in run `run`,
/// counted over all seeds.
Experiment experiment_under(const Experiment& base, const Condition& condition, std::size_t run);

/// `count` runs, the first of them number `first_run`, with the plant's own states and outputs, and its true inputs.
/// Plants with the same parameters are simulated together, each run with the start and the inputs that it has in the
/// whole set.
///   base         in which the condition's `changes` are made already
///   engine_seed  initial_state_seed(seed, stream)
///   estimators   close the loop of [feedback]; null: the true state does
Dataset runs_under(const Experiment& base, const Condition& condition, std::uint64_t engine_seed, int count,
                   std::size_t first_run = 0, const LoopEstimators& estimators = {});

/// Makes the inputs of runs those that estimators are told. What does not arrive is held, as in flight.
void disturb_inputs(const NoiseConfig& noise, std::uint64_t seed, Dataset& runs);

/// Whether inputs stay as they are between samples: a u(t) of the condition is smooth, random inputs may be held.
bool holds_inputs(const Experiment& base, const Condition& condition);

/// Runs as in the training, as channels, from which estimators without a plant learn.
Dataset fresh_training_runs(const Experiment& experiment, const NoiseConfig& input_noise);

/// The seed of the noise on those: the same noise in another order of runs than a test set's.
std::uint64_t fresh_noise_seed(const Experiment& experiment);

}  // namespace nlo::trainer
