// SPDX-License-Identifier: MIT
// The checks of an experiment, one file for each subject. All throw KeyError; each may rely on those before it.
#pragma once

#include <cstddef>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

inline constexpr double kMostSamples = 1e7;  ///< samples of a trajectory
inline constexpr double kMostNumbers = 1e9;  ///< numbers of a training set: 8 GB of doubles

/// [plant] and [simulation]: a plant that exists, a horizon that fits into memory, initial states of its size.
void check_plant_and_simulation(const Experiment& experiment);

/// The keys initial_... of [simulation], for a plant of `nx` states.
void check_initial_states(const SimulationConfig& simulation, std::size_t nx);

/// [excitation] and other random values of a plant's runs: process noise, parameters with a range.
void check_excitation(const Experiment& experiment);

/// [feedback]: laws that can be read, limits, an observer that knows every state and is told u.
void check_feedback(const Experiment& experiment);

/// Angles among the outputs and the estimated states, of a plant or of logs.
void check_angles(const Experiment& experiment);

/// [loss]
void check_losses(const Experiment& experiment);

/// [training]: keys that contradict the plant, the logs, the observer or each other.
void check_training(const Experiment& experiment);

/// [training] mirror: the derivatives of logged columns, and the equations of a plant.
void check_mirror(const Experiment& experiment);

/// [training] transient: it is about the start of whole trajectories, so keys that draw samples elsewhere contradict
/// it.
void check_transient(const Experiment& experiment);

}  // namespace nlo::trainer
