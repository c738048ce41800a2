// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <utility>
#include <vector>

#include "trainer/base/number_text.h"
#include "trainer/config/key_error.h"
#include "trainer/experiments/experiment_checks.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/plant_registry.h"

namespace nlo::trainer {
namespace {

[[noreturn]] void fail(const std::string& key, const std::string& what) {
  throw KeyError("simulation." + key, fmt::format("[simulation] {}{}", key, what));
}

void check_box(const SimulationConfig& s, std::size_t nx) {
  for (const auto& [key, size] :
       {std::pair{"initial_low", s.initial_low.size()}, std::pair{"initial_high", s.initial_high.size()}}) {
    if (size == nx) continue;
    if (size == 0)
      throw KeyError("simulation", fmt::format("[simulation] {} is missing; give the corner of the training box, "
                                               "{} numbers, one for each state",
                                               key, nx));
    fail(key, fmt::format(" has {} numbers; the plant has {} states", size, nx));
  }
  for (std::size_t i = 0; i < nx; ++i)
    if (!(s.initial_low[i] <= s.initial_high[i]))
      fail("initial_high", fmt::format("[{0}] is {1}; it must not be below initial_low[{0}], {2}", i,
                                       shortest_text(s.initial_high[i]), shortest_text(s.initial_low[i])));
}

/// Checks a list of states: each row must have one number for each state.
void check_rows(const char* key, const std::vector<std::vector<double>>& rows, std::size_t nx) {
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (rows[i].size() != nx)
      fail(key, fmt::format("[{}] has {} numbers; the plant has {} states", i, rows[i].size(), nx));
}

void check_circle(const SimulationConfig& s, std::size_t nx) {
  if (!s.initial_centre.empty() && s.initial_centre.size() != nx)
    fail("initial_centre", fmt::format(" has {} numbers; the plant has {} states", s.initial_centre.size(), nx));
  if (s.initial_axes.size() != 2)
    fail("initial_axes", fmt::format(" has {} half axes; a circle has two, each with {} numbers, such as "
                                     "[[2, 0], [0, 2]] for radius 2 in a plane",
                                     s.initial_axes.size(), nx));
  check_rows("initial_axes", s.initial_axes, nx);
}

void check_list(const SimulationConfig& s, std::size_t nx) {
  if (s.initial_states.empty())
    fail("initial_states", fmt::format(" is empty; list at least one state of {} numbers: [[0.1, 0.2], ...]", nx));
  check_rows("initial_states", s.initial_states, nx);
}

}  // namespace

void check_initial_states(const SimulationConfig& s, std::size_t nx) {
  using enum InitialDistribution;
  const InitialDistribution kind = s.initial_distribution;
  const bool box = kind == kUniform || kind == kGaussian;
  struct Given {
    const char* key;
    bool is_given, belongs;
  };
  for (const auto& [key, is_given, belongs] :
       {Given{"initial_low", !s.initial_low.empty(), box}, Given{"initial_high", !s.initial_high.empty(), box},
        Given{"initial_centre", !s.initial_centre.empty(), kind == kCircle},
        Given{"initial_axes", !s.initial_axes.empty(), kind == kCircle},
        Given{"initial_states", !s.initial_states.empty(), kind == kList}})
    if (is_given && !belongs)
      fail(key, fmt::format(" has no effect with initial_distribution = \"{}\"; remove one of them", to_name(kind)));
  if (kind == kCircle) return check_circle(s, nx);
  if (kind == kList) return check_list(s, nx);
  return check_box(s, nx);
}

void check_plant_and_simulation(const Experiment& e) {
  const auto plant = make_plant(*e.plant);
  PlantChannels(*e.plant, *plant);
  const std::size_t nx = plant->states().size();
  const SimulationConfig& s = e.simulation;
  check_initial_states(s, nx);
  const double samples = s.horizon_s / s.sample_period_s;
  if (!(samples >= 1.0))
    throw KeyError(
        "simulation.horizon_s",
        fmt::format(
            "[simulation] horizon_s is {} and sample_period_s is {}; the horizon must be longer than the sample period",
            shortest_text(s.horizon_s), shortest_text(s.sample_period_s)));
  if (samples > kMostSamples || samples * s.trajectories * static_cast<double>(nx) > kMostNumbers)
    throw KeyError("simulation.horizon_s",
                   fmt::format("[simulation] has {} trajectories of {:.3g} samples, which do not fit into memory: use "
                               "a shorter horizon, a longer sample period or fewer trajectories",
                               s.trajectories, samples));
  if (e.training.segment_s > s.horizon_s)
    throw KeyError("training.segment_s", fmt::format("[training] segment_s is {}; it must be at most horizon_s, {}",
                                                     shortest_text(e.training.segment_s), shortest_text(s.horizon_s)));
}

}  // namespace nlo::trainer
