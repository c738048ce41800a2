// SPDX-License-Identifier: MIT
#include "trainer/plants/run_range.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "trainer/base/number_text.h"
#include "trainer/plants/initial_states.h"

namespace nlo::trainer {
namespace {

constexpr double kLeaves = 10.0;  // a state leaves the box beyond this many half widths
// A drift doubles from half of the horizon to its end; a state that settles or oscillates does not.
constexpr double kGrowth = 1.8;
// Smallest growth that is reported for a state that starts at one point; a constant force from rest gives 4.
constexpr double kRunaway = 5.0;
constexpr double kOutside = 3.0;  // [half widths]; a state that grows below this is slow, not unbounded

/// Statistics of one state over all runs, relative to the centre of the box.
struct Range {
  double farthest = 0.0, farthest_s = 0.0;  ///< largest |x - centre| and its time
  double value = 0.0;                       ///< value of x at that time
  const std::string* run = nullptr;
  double first_half = 0.0, last_quarter = 0.0;  ///< largest |x - centre| in these parts of the horizon
  double leaves_s = 0.0;                        ///< first time beyond ten half widths
  std::size_t leaving = 0;                      ///< number of runs that leave the box
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

bool reads(const std::string& expression, const std::string& name) {
  const auto in_name = [&](std::size_t at) {
    return at < expression.size() &&
           (std::isalnum(static_cast<unsigned char>(expression[at])) || expression[at] == '_');
  };
  for (std::size_t at = expression.find(name); at != std::string::npos; at = expression.find(name, at + 1))
    if (!(at > 0 && in_name(at - 1)) && !in_name(at + name.size())) return true;
  return false;
}

/// Returns true if an output measures this state itself and nothing else of the plant depends on it, like the count of
/// an encoder.
bool is_count(const PlantConfig& plant, const std::string& state) {
  if (std::find(plant.outputs.begin(), plant.outputs.end(), state) == plant.outputs.end()) return false;
  for (const std::string& derivative : plant.derivative)
    if (reads(derivative, state)) return false;
  for (const std::vector<std::string>& row : plant.input_field)
    for (const std::string& entry : row)
      if (reads(entry, state)) return false;
  return true;
}

/// Returns the remedy for an encoder, whose count grows with the horizon. A shorter horizon is not a remedy.
std::string of_a_count(const Experiment& experiment, const std::string& state) {
  const ObserverConfig& o = experiment.observer;
  if (o.features == FeatureSet::kLatentMinusOutput && o.output_injection == Injection::kUnitGain)
    return fmt::format(
        "Nothing else in the plant depends on it, and its output is relative (features = \"latent_minus_output\"), so "
        "it may count without end in flight. If {} is an angle, give its full turn in [plant] state_wraps and "
        "output_wraps",
        state);
  return fmt::format(
      "Nothing else in the plant depends on it. If {} is an angle, give its full turn in [plant] state_wraps and "
      "output_wraps. If it counts without end, set [observer] features = \"latent_minus_output\" and output_injection "
      "= \"unit_gain\", which make its output relative; otherwise flight clamps it to the range of training",
      state);
}

std::string what_helps(const Experiment& experiment, const Dataset& runs, const std::string& state) {
  if (is_count(*experiment.plant, state)) return of_a_count(experiment, state);
  const std::string meant =
      "An observer learns this whole range, and its error is proportional to the range. If the plant is not meant to "
      "go there, ";
  const std::string horizon =
      fmt::format("a shorter [simulation] horizon_s (now {})", shortest_text(experiment.simulation.horizon_s));
  if (experiment.feedback)
    return meant + "its [feedback] does not stabilise it: change the law or the actuators' limits, or use " + horizon;
  if (!runs.inputs.empty() || !experiment.plant->inputs.empty())
    return meant + "add a stabilising [feedback], or use " + horizon;
  return meant + "use " + horizon;
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
        fmt::format("starts between {} and {}{}", shortest_text(box.low(row)), shortest_text(box.high(row)), unit);
    const std::string far =
        fmt::format("{:.3g}{} at t = {:.3g} s of {}", range.value, unit, range.farthest_s, *range.run);
    warnings.push_back(
        range.leaving > 0
            ? fmt::format("{} {}, but {} of {} runs go beyond ten half widths of that box, the first at t = {:.3g} s; "
                          "the farthest value is {}{}. {}",
                          state.name, starts, range.leaving, runs.trajectories.size(), range.leaves_s, far,
                          grows ? ", still growing" : "", what_helps(experiment, runs, state.name))
            : fmt::format(
                  "{} {} and grows without bound: {:.3g}{} from its middle in the first half of the horizon, {}. {}",
                  state.name, starts, range.first_half, unit, far, what_helps(experiment, runs, state.name)));
  }
  return warnings;
}

std::string counted_state(const PlantConfig& plant) {
  for (std::size_t i = 0; i < plant.states.size(); ++i)
    if (!(i < plant.state_wraps.size() && plant.state_wraps[i] > 0.0) && is_count(plant, plant.states[i]))
      return plant.states[i];
  return {};
}

}  // namespace nlo::trainer
