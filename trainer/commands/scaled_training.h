// SPDX-License-Identifier: MIT
// The observer of k D: a model's experiment trained again with its eigenvalues times k, held fixed.
#pragma once

#include <string>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"
#include "trainer/jobs/kept_training.h"

namespace nlo::trainer {

/// `experiment` with k times the eigenvalues that `model` has learned, clocks k times as fast, and `steps` of training
/// (0: its own, at most 2,000). Throws codegen::Error when rk4 would diverge, or when the eigenvalues of several
/// outputs have been learned apart, which no experiment can hold.
Experiment scaled_experiment(const Experiment& experiment, const codegen::Model& model, double k, int steps);

/// Trains it on its own simulations and keeps that below `output`, if there is one; F stays that of `model`, which it
/// becomes. Throws codegen::Error when the training diverges.
JobEnd train_scaled(const Experiment& experiment, const std::string& output, const JobContext& context,
                    codegen::Model& model);

}  // namespace nlo::trainer
