// SPDX-License-Identifier: MIT
// Structures that a derived experiment may have instead of a linear latent system: gated units, and a prior if the
// equations of the plant are known. Short trainings of all of them (pilot.h) decide.
#pragma once

#include <string>
#include <vector>

#include "trainer/experiments/load_experiment.h"
#include "trainer/structures/trainable_structure.h"

namespace nlo::trainer {

/// Properties of the data on which the settings of an observer with units depend.
struct DataScales {
  double sample_period_s = 0.0;
  double run_length_s = 0.0;
  double slowest = 0.0;  ///< initial rate of the slowest unit [1/s]: the rate of the slowest mode of the linear latent
                         ///< system
};

/// Returns the experiment that the text of `derived` gives, which is the content of derived.toml. It has the number of
/// threads of `base`. Throws codegen::Error if the checks refuse it.
Experiment checked(const Experiment& derived, const Experiment& base);

/// Turns `base`, the draft with the keys that determine its data, into an experiment with this structure. Keys of the
/// draft keep their values; keys of [observer] do so if the draft names this structure. Throws codegen::Error if the
/// structure does not fit.
///   has_units  false: a prior is the tuned filter alone, if the draft leaves `units` open
Experiment with_structure(const DraftExperiment& draft, const Experiment& base, const TrainableStructure& structure,
                          const DataScales& scales, bool has_units = true);

/// Returns true for a prior without units: an extended Kalman filter.
bool is_filter(const Experiment& experiment);

/// Returns the reason why an observer of this structure is not as good in flight as its validation says, with the
/// remedy; empty if there is none.
std::string misleading_validation(const TrainableStructure& structure, const Experiment& base);

struct Rival {
  Experiment experiment;  ///< complete and checked
  std::string not_tried;  ///< reason why its short training would mislead, with the remedy; empty: it may be tried
};

/// Returns with_structure() for each structure that fits; for a prior, before it, the filter alone. It leaves out
///   - all structures, if the draft chooses the structure or gives a key of [observer] that only a linear latent system
///     has
///   - gated units, if a plant is simulated without noise: they lose accuracy to keep noise out
///   - each structure whose own checks refuse the experiment: a prior needs equations, and no angle besides sines and
///     cosines
/// A prior is not tried
///   - on a plant that is simulated exactly. There it would win, but it is the worst choice if the real plant differs.
///     With parameters 20 % off, the error for a pendulum was 0.72 with a prior and 0.23 with a KKL observer. A prior's
///     gain goes to zero: after a jump of the leak of two tanks, its estimate stayed wrong for 1,790 s. The estimate of
///     a KKL observer was wrong for 41 s
///   - on a plant whose encoder counts without end (counted_state()). In flight a prior would clamp the count to the
///     range that training covered. A linear latent system reads the count relative to z and has no such limit
std::vector<Rival> structure_rivals(const DraftExperiment& draft, const Experiment& base, const DataScales& scales);

}  // namespace nlo::trainer
