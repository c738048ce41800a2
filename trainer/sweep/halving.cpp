// SPDX-License-Identifier: MIT
#include "trainer/sweep/halving.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace nlo::trainer {

std::vector<Rung> halving_rungs(std::size_t candidates, double seconds) {
  std::vector<Rung> rungs = {{candidates}};
  constexpr std::size_t kLast = 2;
  while (rungs.back().candidates > kLast)
    rungs.push_back({std::max(kLast, (rungs.back().candidates + kKeptPart / 2) / kKeptPart)});
  const double share =
      seconds / (static_cast<double>(rungs.size()) + 1.0 / static_cast<double>(rungs.back().candidates));
  for (Rung& rung : rungs) rung.seconds = share / static_cast<double>(rung.candidates);
  return rungs;
}

std::size_t candidates_for(double seconds, double setup_s) {
  constexpr std::size_t kFewest = 4, kMost = 64;
  const double shortest = std::max(2.0, 3.0 * setup_s);  // of a training that says something about longer ones [s]
  std::size_t candidates = kFewest;
  while (candidates < kMost && halving_rungs(candidates + 1, seconds).front().seconds >= shortest) ++candidates;
  return candidates;
}

double steps_within(const TrainingPace& pace, double seconds) {
  constexpr double kLeast = 0.25;
  return std::max(seconds - pace.setup_s, kLeast * seconds) * pace.steps_per_s;
}

double minutes_for(const TrainingPace& pace, double steps) {
  constexpr double kForTrainings = 0.8, kLongest = 1e5;
  const auto suffice = [&](double minutes) {
    const double seconds = 60.0 * kForTrainings * minutes;
    return steps_within(pace, halving_rungs(candidates_for(seconds, pace.setup_s), seconds).back().seconds) >= steps;
  };
  double minutes = 1.0;
  while (minutes < kLongest && !suffice(minutes)) minutes = std::ceil(1.05 * minutes);
  return minutes;
}

std::vector<std::size_t> best_of(const std::vector<std::optional<double>>& errors, std::size_t count) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < errors.size(); ++i)
    if (errors[i]) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return *errors[a] < *errors[b]; });
  order.resize(std::min(count, order.size()));
  return order;
}

}  // namespace nlo::trainer
