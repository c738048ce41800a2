// SPDX-License-Identifier: MIT
#include "trainer/plants/run_range.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "trainer/base/number_text.h"
#include "trainer/plants/initial_states.h"

namespace nlo::trainer {
namespace {

constexpr double kLeaves = 10.0;  // half widths of the box
constexpr double kGrowth = 1.8;  // a drift doubles from half of the horizon to its end; what settles or swings does not
constexpr double kRunaway = 5.0;  // the same of a state that starts at one point: rest under a constant force is 4
constexpr double kOutside = 3.0;  // half widths: what grows within its box is slow, not lost

/// One state over all runs, seen from the centre of the box.
struct Range {
  double farthest = 0.0, farthest_s = 0.0;  ///< |x - centre|, and when
  double value = 0.0;                       ///< x there
  const std::string* run = nullptr;
  double first_half = 0.0, last_quarter = 0.0;  ///< farthest then
  double leaves_s = 0.0;                        ///< first time beyond ten half widths
  std::size_t leaving = 0;                      ///< runs that go beyond
};

Range range_of(const Dataset& runs, Eigen::Index state, double centre, double half_width) {
  Range range;
  for (const Trajectory& run : runs.trajectories) {
    bool left = false;
    const double end_s = run.time_s[run.samples() - 1];
    for (Eigen::Index k = 0; k < run.samples(); ++k) {
      const double x = run.states(state, k), away = std::abs(x - centre), t = run.time_s[k];
      if (away > range.farthest) range.farthest = away, range.farthest_s = t, range.value = x, range.run = &run.source;
      if (t <= 0.5 * end_s) range.first_half = std::max(range.first_half, away);
      if (t >= 0.75 * end_s) range.last_quarter = std::max(range.last_quarter, away);
      if (left || half_width == 0.0 || away <= kLeaves * half_width) continue;
      left = true;
      range.leaves_s = range.leaving == 0 ? t : std::min(range.leaves_s, t);
      ++range.leaving;
    }
  }
  return range;
}

std::string what_helps(const Experiment& experiment, const Dataset& runs) {
  std::string horizon =
      fmt::format("a shorter [simulation] horizon_s (now {})", shortest_text(experiment.simulation.horizon_s));
  if (experiment.feedback)
    return "its [feedback] does not hold it: change the law or the actuators' limits, or take " + horizon;
  if (!runs.inputs.empty() || !experiment.plant->inputs.empty())
    return "close the loop that holds it by [feedback], or take " + horizon;
  return "take " + horizon;
}

}  // namespace

std::vector<std::string> range_warnings(const Dataset& runs, const Experiment& experiment) {
  const InitialBox box = initial_box(experiment.simulation);
  std::vector<std::string> warnings;
  for (std::size_t i = 0; i < runs.states.size(); ++i) {
    const Channel& state = runs.states[i];
    if (state.wrap > 0.0) continue;
    const auto row = static_cast<Eigen::Index>(i);
    const double centre = 0.5 * (box.low(row) + box.high(row)), half_width = 0.5 * (box.high(row) - box.low(row));
    const Range range = range_of(runs, row, centre, half_width);
    const bool grows = range.last_quarter > (half_width > 0.0 ? kGrowth : kRunaway) * range.first_half &&
                       range.last_quarter > kOutside * half_width;
    if (range.leaving == 0 && !grows) continue;
    const std::string unit = state.unit.empty() ? "" : " " + state.unit;
    const std::string starts =
        fmt::format("starts within {} and {}{}", shortest_text(box.low(row)), shortest_text(box.high(row)), unit);
    const std::string far =
        fmt::format("{:.3g}{} at t = {:.3g} s of {}", range.value, unit, range.farthest_s, *range.run);
    warnings.push_back(
        range.leaving > 0
            ? fmt::format("{} {}, and {} of {} runs leave that box by more than ten times, the first at t = {:.3g} s; "
                          "farthest {}{}. An observer learns all of this range, and its error is a share of it; where "
                          "the plant is not meant to go there, {}",
                          state.name, starts, range.leaving, runs.trajectories.size(), range.leaves_s, far,
                          grows ? ", still growing" : "", what_helps(experiment, runs))
            : fmt::format(
                  "{} {} and grows without bound: {:.3g}{} from its middle in the first half of the horizon, {}. "
                  "An observer learns all of this range, and its error is a share of it; where the plant is not meant "
                  "to go there, {}",
                  state.name, starts, range.first_half, unit, far, what_helps(experiment, runs)));
  }
  return warnings;
}

}  // namespace nlo::trainer
