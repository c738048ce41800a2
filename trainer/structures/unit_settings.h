// SPDX-License-Identifier: MIT
// Keys of [observer] for structures with gated units: the number of units and their initial rates.
#pragma once

#include <vector>

#include "trainer/structures/trainable_structure.h"

namespace nlo::trainer {

struct UnitSettings {
  int units = 32;                  ///< 0: a prior without corrections
  std::vector<double> rates = {};  ///< slowest and fastest initial rate [1/s]
};

/// Returns the keys units and rates.
std::vector<Key<ObserverConfig>> unit_keys();

/// Changes the number of units and their rates, for a search.
void vary_units(UnitSettings& units, Draws& draws);

/// Replaces the training settings of another structure by those that suit gated units.
void train_units(Experiment& experiment);

/// Throws KeyError for keys that do not fit gated units. `what`: "a gated observer".
void check_units(const Experiment& experiment, const char* what);

/// Returns the biases of the units' rates. The rates are evenly spaced by their logarithms; (1 + tanh a) / 2 = 1 -
/// exp(-rate period).
std::vector<float> initial_rates(const UnitSettings& settings, double period_s);

}  // namespace nlo::trainer
