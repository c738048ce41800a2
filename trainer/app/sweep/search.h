// SPDX-License-Identifier: MIT
// The candidates of nlo train --auto: variants of a given experiment with other structures, eigenvalues or units,
// widths and learning rates. Successive halving (Jamieson and Talwalkar 2016): many trainings are short at first; the
// best quarter is trained four times as long; and so on. Rungs take the same time each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// The draw `index` of those about `base`, checked; 0 is `base` itself. Empty where the draw is no experiment: a
/// structure that cannot do what this one asks. It depends on `base` and `index` alone.
///   sample_period_s  of the data; the time scales of another structure start from it
std::optional<Experiment> drawn_experiment(const Experiment& base, double sample_period_s, std::uint64_t index);

/// The keys in which an experiment is not as another one, without those of training's length, which a search sets.
struct Difference {
  std::string full;   ///< "observer.units = 24, training.learning_rate = 0.003"; empty: none
  std::string title;  ///< differences between candidates: "gated units=24 learning_rate=0.003"
};
Difference difference(const Experiment& base, const Experiment& other);

/// So many steps, with validation errors twenty times or as often as before. Its source_text says so.
void set_steps(Experiment& experiment, int steps);

struct Rung {
  std::size_t candidates = 0;
  double seconds = 0.0;  ///< time of the training of each
};

inline constexpr std::size_t kKeptPart = 4;  ///< one in so many goes on, two at least

/// Rungs of so many candidates that take `seconds` together with one more training as long as the last rung's: that of
/// the winner, for its model. `candidates` > 0, `seconds` > 0.
std::vector<Rung> halving_rungs(std::size_t candidates, double seconds);

/// Returns a number of candidates, 4 to 64, such that each gets two seconds in the first rung, or three times the setup
/// time of a training if that is more.
std::size_t candidates_for(double seconds, double setup_s);

/// Speed of a training, measured before the search.
struct TrainingPace {
  double setup_s = 0.0, steps_per_s = 0.0;
};

/// Steps of a training in `seconds`: in the time after its setup, at least a quarter.
double steps_within(const TrainingPace& pace, double seconds);

/// A search ships a model that is trained for this share of the experiment's steps, or none.
inline constexpr double kLeastShareOfSteps = 0.1;

/// Whole minutes of a search whose last rung gives each training `steps` steps, when looking for candidates takes its
/// share first.
double minutes_for(const TrainingPace& pace, double steps);

/// Which of a rung go on: the `count` of least error, in that order; equal ones by their place. One without an error
/// (its training diverged) never does.
std::vector<std::size_t> best_of(const std::vector<std::optional<double>>& errors, std::size_t count);

}  // namespace nlo::trainer
