// SPDX-License-Identifier: MIT
// Test problems for the linear latent system: one mode in each variant, with its reference filter and loss; and the
// modes of a real observer.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/sensitivity/plain_latent.h"
#include "trainer/gradients/sensitivity/linear_latent.h"

namespace nlo::trainer {

using testing::Cd;
using testing::plain_filter;
using testing::plain_injection;

inline constexpr double kPeriod = 0.02;
inline constexpr int kLength = 120;

inline constexpr Hold kHolds[] = {Hold::kZeroOrder, Hold::kFirstOrder, Hold::kRk4};

inline std::string name_of(Hold hold) {
  return hold == Hold::kZeroOrder ? "zero_order" : hold == Hold::kFirstOrder ? "first_order" : "rk4";
}

/// One mode on eight lanes, each with its own outputs.
struct Problem {
  LatentShape shape;
  std::vector<float> parameters;
  std::vector<double> eigenvalues;
  std::vector<double> steps_s;
  SegmentGroup group;

  Problem(Hold hold, Injection injection, bool pair, bool jittered, bool steady, bool command = false) {
    shape.hold = hold;
    if (command) shape.commands_from = 0;
    shape.injection = injection;
    shape.starts_steady = steady;
    shape.modes = {{.pair = pair, .row = 0, .reading = 0}};
    shape.rows = shape.learned = pair ? 2 : 1;
    parameters = pair ? std::vector<float>{0.4F, 1.1F} : std::vector<float>{0.4F};
    eigenvalues.resize(parameters.size());
    eigenvalues_from_parameters(shape, parameters.data(), eigenvalues.data());
    std::mt19937 random(11);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    group.length = kLength;
    group.lanes = kGroup;
    group.readings.resize(group.at(1, 0));
    group.latent.resize(group.at(shape.rows, 0));
    group.cotangent.resize(group.at(shape.rows, 0));
    for (float& y : group.readings) y = static_cast<float>(1.5 * uniform(random) + 0.5);
    for (float& g : group.cotangent) g = static_cast<float>(uniform(random) + 0.5);
    if (!jittered) {
      steps_s = {kPeriod};
      return;
    }
    for (int i = 0; i < 7; ++i) steps_s.push_back(kPeriod * (1.0 + 0.8 * uniform(random)));
    for (std::size_t i = 0; i < group.at(1, 0); ++i) group.step_of.push_back(static_cast<int>(random() % 7));
  }

  Cd lambda(double p, double q) const { return {-std::exp(p), shape.modes[0].pair ? std::exp(q) : 0.0}; }
  Cd lambda() const { return lambda(p(), q()); }
  double p() const { return static_cast<double>(parameters[0]); }
  double q() const { return shape.modes[0].pair ? static_cast<double>(parameters[1]) : 0.0; }

  std::vector<double> outputs(int lane) const {
    std::vector<double> y;
    for (int t = 0; t < kLength; ++t) {
      y.push_back(static_cast<double>(group.readings[group.at(0, t) + static_cast<std::size_t>(lane)]));
    }
    return y;
  }
  std::vector<double> steps(int lane) const {
    std::vector<double> h;
    for (int t = 0; t < kLength; ++t) {
      const std::size_t i = group.at(0, t) + static_cast<std::size_t>(lane);
      h.push_back(steps_s[group.step_of.empty() ? 0 : static_cast<std::size_t>(group.step_of[i])]);
    }
    return h;
  }
  std::vector<Cd> plain(Cd at, int lane) const {
    const Cd f = plain_injection(shape.injection, shape.modes[0].pair, at);
    return plain_filter(shape.hold, at, f, shape.starts_steady, outputs(lane), steps(lane), shape.ahead(0));
  }
  /// Returns l, the sum of cotangent times z; `size` also receives the sum of the absolute values of the terms.
  double loss(double at_p, double at_q, double* size = nullptr) const {
    double sum = 0.0;
    for (int lane = 0; lane < kGroup; ++lane) {
      const std::vector<Cd> z = plain(lambda(at_p, at_q), lane);
      for (int t = 0; t < kLength; ++t) {
        for (int row = 0; row < shape.rows; ++row) {
          const double g = static_cast<double>(group.cotangent[group.at(row, t) + static_cast<std::size_t>(lane)]);
          const Cd at = z[static_cast<std::size_t>(t)];
          sum += g * (row == 0 ? at.real() : at.imag());
          if (size != nullptr) *size += std::abs(g) * std::abs(at) * std::abs(lambda(at_p, at_q));
        }
      }
    }
    return sum;
  }
  void run_filter() {
    Coefficients coefficients;
    coefficients.compute(shape, eigenvalues.data(), steps_s);
    filter(shape, coefficients, group);
  }
  void run_adjoint() {
    Coefficients coefficients;
    coefficients.compute(shape, eigenvalues.data(), steps_s);
    filter(shape, coefficients, group);
    adjoint_filter(shape, coefficients, eigenvalues.data(), group);
  }
};

/// Calls check(problem) for each hold, injection, kind of mode, sampling and start, for modes driven by outputs and by
/// inputs.
template <class Check>
void for_all_problems(const Check& check) {
  for (const Hold hold : kHolds) {
    for (const Injection injection : {Injection::kOnes, Injection::kUnitGain}) {
      for (const bool pair : {false, true}) {
        for (const bool jittered : {false, true}) {
          for (const auto& [steady, command] : {std::pair{false, false}, {true, false}, {false, true}}) {
            SCOPED_TRACE(name_of(hold) + (injection == Injection::kOnes ? " ones" : " unit_gain") +
                         (pair ? " pair" : " real") + (jittered ? " jittered" : " uniform") +
                         (steady ? " steady" : " zero") + (command ? " command" : ""));
            Problem problem(hold, injection, pair, jittered, steady, command);
            check(problem);
            if (::testing::Test::HasFatalFailure()) return;
          }
        }
      }
    }
  }
}

/// A pair and two real modes on two outputs, and a clock, as in a real observer.
inline LatentShape mixed_shape() {
  LatentShape shape;
  shape.modes = {{.pair = true, .row = 0, .reading = 0},
                 {.pair = true, .row = 2, .reading = 1},
                 {.pair = false, .row = 4, .reading = 0},
                 {.pair = false, .row = 5, .reading = 1},
                 {.pair = false, .row = 6, .reading = -1}};
  shape.rows = 7;
  shape.learned = 6;
  shape.starts_steady = true;
  return shape;
}
inline constexpr double kMixed[7] = {-2.0, 3.0, -0.5, 8.0, -1.0, -12.0, -0.25};

}  // namespace nlo::trainer
