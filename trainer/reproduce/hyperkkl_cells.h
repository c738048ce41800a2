// SPDX-License-Identifier: MIT
// The benchmark of driven observers of HyperKKL (arXiv 2603.29744): its plants, its inputs, and its smallest published
// errors.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "trainer/config/experiment.h"
#include "trainer/plants/excitation.h"
#include "trainer/plants/run_random.h"

namespace nlo::trainer::reproduction {

/// u(t) of one run: 0, A, A sin(w t + phi) or A sign(sin(w t)).
struct DrivenInput {
  InputSignal kind = InputSignal::kZero;
  double amplitude = 0.0, frequency = 0.0, phase = 0.0;  ///< A, w [rad/s], phi

  double operator()(double time_s) const;
};

/// Ranges from which the input of a run is drawn uniformly. For a constant, A is negated with a probability of 1/2.
struct InputRange {
  const char* title;
  InputSignal kind = InputSignal::kZero;
  double least = 0.0, most = 0.0;       ///< A
  double slowest = 0.0, fastest = 0.0;  ///< w [rad/s]
  bool sign = false;
};

/// Zero; constants in [-1, 1]; sines with A in [0.1, 1] and w in [0.5, 3]; squares with A in [0.1, 1], w in [0.5, 2].
inline constexpr std::array<InputRange, 4> kKnownInputs{{
    {"zero", InputSignal::kZero},
    {"constant", InputSignal::kConstant, -1.0, 1.0},
    {"sine", InputSignal::kSine, 0.1, 1.0, 0.5, 3.0},
    {"square", InputSignal::kSquare, 0.1, 1.0, 0.5, 2.0},
}};

/// Out of distribution: constants -2 and 2; sines with A in [1, 2] and w in [3, 6]; squares with A in [1, 2] and w in
/// [2, 4].
inline constexpr std::array<InputRange, 3> kFarInputs{{
    {"constant -2 or 2", InputSignal::kConstant, 2.0, 2.0, 0.0, 0.0, true},
    {"sine, A 1-2, w 3-6", InputSignal::kSine, 1.0, 2.0, 3.0, 6.0},
    {"square, A 1-2, w 2-4", InputSignal::kSquare, 1.0, 2.0, 2.0, 4.0},
}};

DrivenInput draw_input(const InputRange& range, RunRandom& random);

/// Draws a Latin hypercube over [initial_low, initial_high], n_x x n: in every state, each of n runs has its own slice
/// of width 1/n.
Eigen::MatrixXd latin_hypercube(const SimulationConfig& simulation, Eigen::Index count, RunRandom& random);

struct BenchmarkPlant {
  const char* title;
  const char* experiment;           ///< in trainer/experiments/
  std::array<double, 3> low, high;  ///< range of the initial states, n_x; training may start elsewhere
  /// Smallest published SMAPE [%] of HyperKKL's two methods, in the order of kKnownInputs. 0: not published.
  std::array<double, 4> published;
};

inline constexpr std::array<BenchmarkPlant, 5> kBenchmarkPlants{{
    {"Duffing", "hyperkkl/duffing", {-1.0, -1.0}, {1.0, 1.0}, {5.6, 21.1, 22.7, 21.3}},
    {"Van der Pol", "hyperkkl/van_der_pol", {-3.0, -3.0}, {3.0, 3.0}, {5.0, 26.0, 15.5, 17.9}},
    {"Roessler", "hyperkkl/roessler", {-10.0, -10.0, -10.0}, {10.0, 10.0, 10.0}, {52.7, 55.4, 53.5, 54.0}},
    {"FitzHugh-Nagumo", "hyperkkl/fitzhugh_nagumo", {-2.5, -1.5}, {2.5, 1.5}, {9.8, 42.1, 30.9, 32.5}},
    {"Lorenz", "hyperkkl/lorenz", {-20.0, -30.0, 0.0}, {20.0, 30.0, 50.0}, {}},
}};

}  // namespace nlo::trainer::reproduction
