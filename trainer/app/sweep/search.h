// SPDX-License-Identifier: MIT
// The candidates of nlo train --auto: variants of a given experiment with other structures, eigenvalues or units,
// widths and learning rates. Successive halving (Jamieson and Talwalkar 2016): many trainings are short at first; the
// best quarter is trained four times as long; and so on. All rungs take the same time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// Returns draw number `index` around `base`, checked; 0 is `base` itself. Returns nothing if the draw is not a valid
/// experiment, because its structure does not support all keys. It depends only on `base` and `index`.
///   sample_period_s  of the data; the time scales of another structure start from it
std::optional<Experiment> drawn_experiment(const Experiment& base, double sample_period_s, std::uint64_t index);

/// The keys in which two experiments differ, without those of the training's length, which a search sets.
struct Difference {
  std::string full;   ///< "observer.units = 24, training.learning_rate = 0.003"; empty: none
  std::string title;  ///< differences between candidates: "gated units=24 learning_rate=0.003"
};
Difference difference(const Experiment& base, const Experiment& other);

/// Sets the number of steps, with twenty validation errors or the same interval as before. Updates source_text.
void set_steps(Experiment& experiment, int steps);

struct Rung {
  std::size_t candidates = 0;
  double seconds = 0.0;  ///< time of each training
};

inline constexpr std::size_t kKeptPart = 4;  ///< one candidate in four continues, at least two

/// Returns rungs for `candidates` > 0 candidates that take `seconds` > 0 together. The time includes one more training
/// as long as those of the last rung: the final training of the best candidate.
std::vector<Rung> halving_rungs(std::size_t candidates, double seconds);

/// Returns a number of candidates, 4 to 64, such that each gets two seconds in the first rung, or three times the setup
/// time of a training if that is more.
std::size_t candidates_for(double seconds, double setup_s);

/// Speed of a training, measured before the search.
struct TrainingPace {
  double setup_s = 0.0, steps_per_s = 0.0;
};

/// Returns the steps of a training in `seconds`: in the time after its setup, at least a quarter of the time.
double steps_within(const TrainingPace& pace, double seconds);

/// A search returns a model only if it is trained for this share of the experiment's steps.
inline constexpr double kLeastShareOfSteps = 0.1;

/// Returns the whole minutes of a search whose last rung gives each training `steps` steps, including the time for
/// finding candidates.
double minutes_for(const TrainingPace& pace, double steps);

/// Returns the candidates of a rung that continue: the `count` with the smallest errors, in that order; equal ones by
/// index. A candidate without an error (its training diverged) never continues.
std::vector<std::size_t> best_of(const std::vector<std::optional<double>>& errors, std::size_t count);

}  // namespace nlo::trainer
