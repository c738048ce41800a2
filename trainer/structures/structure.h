// SPDX-License-Identifier: MIT
// The stages of an observer's structure: made from an experiment, normalised, given initial parameters, and turned into
// a model.
#pragma once

#include <vector>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"
#include "trainer/rollout/rollout.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// Returns the structure that an experiment describes, for the channels of a dataset. Features and states are not
/// normalised yet.
///   failing             sensors that may fail
///   read_inputs         known inputs that the observer reads beside the outputs
///   trains_forward_map  a loss contains T, so T is trained even if the observer does not use it in flight
ObserverStructure make_structure(const Experiment& experiment, bool trains_forward_map,
                                 const std::vector<Channel>& outputs, const std::vector<Channel>& states,
                                 const std::vector<Channel>& read_inputs = {}, int failing = 0);

/// Sets the means and scales of the inputs of a network within the latent system. Call it before any roll-out.
void normalise_dynamics(ObserverStructure& structure, const TrainingData& data, ThreadPool& pool);

/// Checks that training can start on this data. Throws codegen::Error as normalise_dynamics() does.
void check_start(const Experiment& experiment, const Dataset& training);

/// Sets means and scales from the training data as in flight (flight_segments). Those of features use all samples,
/// because masks only concern the truth; those of states use the truth that counts. A clock gets the centre and the
/// half width of its range, [0, 1].
void normalise(ObserverStructure& structure, const Rollout& rollout);

/// Returns true if the untrained observer estimates every state: z has rows for them, and a linear path copies them.
bool starts_as_estimator(const ObserverStructure& structure);

/// Returns true if training changes a parameter of the latent system.
bool latent_system_learns(const Experiment& experiment, const ObserverStructure& structure);

/// Returns the initial parameters of the latent system: eigenvalues, or a network.
std::vector<float> initial_dynamics(const ObserverStructure& structure, const Experiment& experiment);

/// Returns the initial parameters. With a linear path, L is the ridge regression of the states on the features, or
/// copies the estimates of the untrained latent system (TrainableStructure::estimate_row).
std::vector<float> initial_parameters(const ObserverStructure& structure, const Experiment& experiment,
                                      const Rollout& rollout);

/// Returns the trained model. `rollout`: the training data as in flight (flight_segments) with these parameters, from
/// which the domain is computed.
codegen::Model to_model(const ObserverStructure& structure, const float* parameters, const Experiment& experiment,
                        const Dataset& dataset, const Rollout& rollout);

}  // namespace nlo::trainer
