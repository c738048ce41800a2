// SPDX-License-Identifier: MIT
// The inputs of simulated runs by [excitation]. For each run and input one of `kinds` is drawn, and then its numbers,
// from a separate stream. The signals use the range [low, high] of the input, its middle c, an amplitude A, times and
// periods T drawn log-uniformly in [shortest_s, longest_s], and a phase p:
//   zero       0
//   constant   uniform in the range
//   steps      levels uniform in the range, each held for a T of its own
//   prbs       two levels uniform in the range, one of them by a coin at each multiple of T
//   sine       c + A sin(2 pi (t / T + p))
//   square     c + A in the first half of each period, c - A in the second
//   multisine  c + A / 5 times the sum of five sines, each with T and p of its own
//   chirp      c + A sin of a phase whose frequency runs from 1 / T1 to 1 / T2, geometrically in time
//   noise      c + white Gaussian noise, low-passed with first order at 1 / T; two of its standard deviations
//              are half the range; reflected at the ends of the range
//   log        a stretch of recorded inputs (logged_inputs.h)
// A signal only has values at samples. Between samples [observer] input_hold determines how they act (simulate_runs.h).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/plants/logged_inputs.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

struct HoldTimes {
  double shortest_s, longest_s;
};

/// Returns the shortest and the longest time of [excitation]. If the shortest is 0, it is replaced by ten sample
/// periods; if the longest is 0, by half the horizon, but at least the shortest.
HoldTimes hold_times(const ExcitationConfig& excitation, const SimulationConfig& simulation);

/// Draws the inputs, n_u x N, with the same bits on every machine.
///   excitation   with n_u ranges, checked (experiments/check_excitation.cpp)
///   engine_seed  initial_state_seed(seed, stream)
///   run          index of the run in the set; its draws do not depend on the number of runs
///   log          read_logged_inputs()
Eigen::MatrixXd draw_inputs(const ExcitationConfig& excitation, const SimulationConfig& simulation,
                            std::uint64_t engine_seed, std::uint64_t run, const LoggedInputs& log = {});

/// Describes the inputs for readers: ("u", "drawn within -1 .. 1 (steps, prbs)").
std::vector<std::pair<std::string, std::string>> describe_inputs(const ExcitationConfig& excitation,
                                                                 const Plant& plant);

}  // namespace nlo::trainer
