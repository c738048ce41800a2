// SPDX-License-Identifier: MIT
// Has a training got anywhere, and if not, why? A run whose best model is the one it started from must not look like a
// success.
#pragma once

#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/learn/training/checkpoint.h"
#include "trainer/rollout/rollout.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// Empty if the run improved on its start; else the reason, for people:
///   the best model is that of step 0 (no validation error below the first), or
///   the loss grew past where it began and stayed: every loss recorded in the last quarter of the run is above the
///   first
/// `metrics`: as in metrics.csv, the first row being step 0.
std::string no_progress(const std::vector<MetricsRow>& metrics);

/// Is the model that training started from the best one because it is good, and not because training failed? True when
///   T* started as the ridge regression of the states on its features (it has a linear path),
///   no step has a lower validation error, and
///   no likely cause of a failure shows: the loss did not grow, every feature stays within its scale, and the data is
///   odd where `mirror` says so
/// Arguments as for likely_causes().
bool closed_form_is_best(const std::vector<MetricsRow>& metrics, const ObserverStructure& structure,
                         const Dataset& dataset, const Rollout& flight);

/// For people: the closed form could not be improved, and ships.
std::string closed_form_text(const std::vector<MetricsRow>& metrics);

/// The likely causes, the most likely one first, each with its mend: a feature that leaves its scale, data that is not
/// odd where `mirror` says so, a learning rate too high, too few steps.
///   metrics  as for no_progress()
///   flight   the training data as flown (flight_segments) with the last parameters
std::string likely_causes(const Experiment& experiment, const std::vector<MetricsRow>& metrics,
                          const ObserverStructure& structure, const Dataset& dataset, const Rollout& flight);

/// The input of T* that reaches furthest from its mean, in units of its scale.
struct LargestFeature {
  std::string name;  ///< "the clock of 0.02 s", "the latent row 3 less alpha"
  double reach = 0.0;
};
LargestFeature largest_feature(const ObserverStructure& structure, const std::vector<Channel>& readings,
                               const Rollout& flight);

}  // namespace nlo::trainer
