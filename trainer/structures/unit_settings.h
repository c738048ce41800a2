// SPDX-License-Identifier: MIT
// [observer] of structures with gated units: how many, and how fast they are at first.
#pragma once

#include <vector>

#include "trainer/structures/trainable_structure.h"

namespace nlo::trainer {

struct UnitSettings {
  int units = 32;
  std::vector<double> rates = {};  ///< slowest and fastest at first [1/s]
};

/// units and rates.
std::vector<Key<ObserverConfig>> unit_keys();

/// Another number of them, and other rates, for a search.
void vary_units(UnitSettings& units, Draws& draws);

/// Replaces another structure's settings of training by those that suit units.
void train_units(Experiment& experiment);

/// Throws KeyError for keys that do not fit gated units. `what`: "a gated observer".
void check_units(const Experiment& experiment, const char* what);

/// Biases of the units' rates: spread evenly over their logarithms, (1 + tanh a) / 2 = 1 - exp(-rate period).
std::vector<float> initial_rates(const UnitSettings& settings, double period_s);

}  // namespace nlo::trainer
