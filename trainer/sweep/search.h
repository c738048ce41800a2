// SPDX-License-Identifier: MIT
// What nlo train --auto tries: experiments about a given one, with other structures, eigenvalues or units, widths and
// learning rates.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// The draw `index` of those about `base`, checked; 0 is `base` itself. Empty where the draw is no experiment: a
/// structure that cannot do what this one asks. It depends on `base` and `index` alone.
///   sample_period_s  of the data: what the time scales of another structure start from
std::optional<Experiment> drawn_experiment(const Experiment& base, double sample_period_s, std::uint64_t index);

/// The keys in which an experiment is not as another one, without those of training's length, which a search sets.
struct Difference {
  std::string full;   ///< "observer.units = 24, training.learning_rate = 0.003"; empty: none
  std::string title;  ///< what tells candidates apart: "gated units=24 learning_rate=0.003"
};
Difference difference(const Experiment& base, const Experiment& other);

/// So many steps, with validation errors twenty times or as often as before. Its source_text says so.
void set_steps(Experiment& experiment, int steps);

}  // namespace nlo::trainer
