// SPDX-License-Identifier: MIT
// The checks of an experiment, one file for each subject. All throw KeyError. Each check may assume that the ones
// before it have passed.
#pragma once

#include <cstddef>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

inline constexpr double kMostSamples = 1e7;  ///< largest number of samples of a trajectory
inline constexpr double kMostNumbers = 1e9;  ///< largest number of values in a training set: 8 GB of doubles

/// Checks [plant] and [simulation]: the plant exists, the horizon fits into memory, initial states have its size.
void check_plant_and_simulation(const Experiment& experiment);

/// Checks the keys initial_... of [simulation] for a plant with `nx` states.
void check_initial_states(const SimulationConfig& simulation, std::size_t nx);

/// Checks [excitation] and other random values of a plant's runs: process noise, parameters with a range.
void check_excitation(const Experiment& experiment);

/// Checks [feedback]: its laws compile, its limits are valid, the observer estimates the states that the laws read, and
/// it reads u.
void check_feedback(const Experiment& experiment);

/// Checks the angles among the outputs and the estimated states, of a plant or of logs.
void check_angles(const Experiment& experiment);

/// Checks [loss].
void check_losses(const Experiment& experiment);

/// Checks [training] for keys that contradict the plant, the logs, the observer or each other.
void check_training(const Experiment& experiment);

/// Checks [training] mirror against the derivatives of logged columns and the equations of a plant.
void check_mirror(const Experiment& experiment);

/// Checks [training] transient. It concerns the start of whole trajectories, so keys that draw samples elsewhere
/// contradict it.
void check_transient(const Experiment& experiment);

}  // namespace nlo::trainer
