// SPDX-License-Identifier: MIT
// Detects a training that did not improve its initial model, and finds the likely reason. Such a training must not look
// like a success.
#pragma once

#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/learn/training/checkpoint.h"
#include "trainer/rollout/rollout.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// Returns an empty text if the run improved its initial model. Otherwise returns the reason as a text for users:
///   the best model is that of step 0 (no validation error is below the first), or
///   the loss grew and stayed large: every loss recorded in the last quarter of the run is above the first.
/// `metrics`: as in metrics.csv; the first row is step 0.
std::string no_progress(const std::vector<MetricsRow>& metrics);

/// Returns true if the initial model is the best one because it is good, and not because training failed:
///   T* started as the ridge regression of the states on its features (it has a linear path),
///   no step has a lower validation error, and
///   there is no sign of a failure: the loss did not grow, every feature stays within its scale, and the data is odd if
///   `mirror` requires it.
/// Arguments are those of likely_causes().
bool closed_form_is_best(const std::vector<MetricsRow>& metrics, const ObserverStructure& structure,
                         const Dataset& dataset, const Rollout& flight);

/// Returns a text for users: no step improved the closed form, which therefore is the result.
std::string closed_form_text(const std::vector<MetricsRow>& metrics);

/// Returns the likely causes with their remedies, the most likely one first: a feature that leaves its scale, data that
/// is not odd although `mirror` is set, too high a learning rate, too few steps.
///   metrics  as for no_progress()
///   flight   training data as in flight (flight_segments) with the last parameters
std::string likely_causes(const Experiment& experiment, const std::vector<MetricsRow>& metrics,
                          const ObserverStructure& structure, const Dataset& dataset, const Rollout& flight);

/// The input of T* that gets furthest from its mean, in units of its scale.
struct LargestFeature {
  std::string name;  ///< "the clock of 0.02 s", "the latent row 3 less alpha"
  double reach = 0.0;
};
LargestFeature largest_feature(const ObserverStructure& structure, const std::vector<Channel>& readings,
                               const Rollout& flight);

}  // namespace nlo::trainer
