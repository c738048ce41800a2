// SPDX-License-Identifier: MIT
// The KKL observer (16) as training sees it: which modes D has, what T* reads, where the parameters lie, and how all of
// it becomes a model. Flat parameters: [eigenvalues of the learned rows | network of T*].
#pragma once

#include <string>
#include <vector>

#include "codegen/model.h"
#include "trainer/config.h"
#include "trainer/nn/network.h"
#include "trainer/rollout.h"

namespace nlo::trainer {

/// One input of T*: latent row plus output_gain times an output (either may be absent: -1), then normalised.
struct Feature {
  int latent = -1;
  int output = -1;
  float output_gain = 0.0F;
  float mean = 0.0F, scale = 1.0F;
};

struct KklStructure {
  LatentShape latent;
  std::vector<double> eigenvalues;  ///< initial, n_z, in row order; clocks stay
  std::vector<Feature> features;
  std::vector<float> state_mean, state_scale;
  NetworkShape network;

  int parameters() const { return latent.learned + network.parameters; }
  /// Eigenvalues at these parameters; the clocks' included.
  std::vector<double> eigenvalues_at(const float* parameters) const;
};

/// The structure an experiment describes, for a dataset's channels; features and states not normalised yet.
KklStructure make_structure(const Experiment& experiment, const std::vector<Channel>& outputs,
                            const std::vector<Channel>& states);

/// Sets means and scales from filtered training data: the features' from the rollout, the states' from the data.
void normalise(KklStructure& structure, Rollout& rollout);

/// Initial parameters; with a linear path, L is the ridge regression of the states on the features.
std::vector<float> initial_parameters(const KklStructure& structure, const Experiment& experiment, Rollout& rollout);

/// The trained model. `rollout`: training data filtered with these parameters, for the domain.
codegen::Model to_model(const KklStructure& structure, const float* parameters, const Experiment& experiment,
                        const Dataset& dataset, Rollout& rollout);

}  // namespace nlo::trainer
