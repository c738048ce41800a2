// SPDX-License-Identifier: MIT
// The life of an observer's structure: from an experiment, through normalisation and initial parameters, to a model.
#pragma once

#include <vector>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"
#include "trainer/rollout/rollout.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// The structure an experiment describes, for a dataset's channels; features and states not normalised yet.
///   failing             sensors that may fail
///   read_inputs         known inputs that the observer reads beside the outputs
///   trains_forward_map  T is there, though the observer does not fly it: a loss is about it
ObserverStructure make_structure(const Experiment& experiment, bool trains_forward_map,
                                 const std::vector<Channel>& outputs, const std::vector<Channel>& states,
                                 const std::vector<Channel>& read_inputs = {}, int failing = 0);

/// Sets the means and scales of the inputs of a network within the latent system, before any roll-out.
void normalise_dynamics(ObserverStructure& structure, const TrainingData& data, ThreadPool& pool);

/// Checks that training can start on this data. Throws codegen::Error as normalise_dynamics() does.
void check_start(const Experiment& experiment, const Dataset& training);

/// Sets means and scales from the training data as flown (flight_segments): those of features over all samples, masked
/// or not, as masks concern the truth alone; those of states over the truth that counts. A clock gets the
/// centre and the half width of its range, [0, 1].
void normalise(ObserverStructure& structure, const Rollout& rollout);

/// Returns true if the untrained observer estimates every state: z has rows for them, and a linear path passes them on.
bool starts_as_estimator(const ObserverStructure& structure);

/// Whether training moves any parameter of the latent system.
bool latent_system_learns(const Experiment& experiment, const ObserverStructure& structure);

/// Initial parameters of the latent system: eigenvalues, or a network.
std::vector<float> initial_dynamics(const ObserverStructure& structure, const Experiment& experiment);

/// Initial parameters; with a linear path, L is the ridge regression of the states on the features, or picks the
/// estimates that the latent system has from the start (TrainableStructure::estimate_row).
std::vector<float> initial_parameters(const ObserverStructure& structure, const Experiment& experiment,
                                      const Rollout& rollout);

/// The trained model. `rollout`: training data as flown (flight_segments) with these parameters, for the domain.
codegen::Model to_model(const ObserverStructure& structure, const float* parameters, const Experiment& experiment,
                        const Dataset& dataset, const Rollout& rollout);

}  // namespace nlo::trainer
