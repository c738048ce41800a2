// SPDX-License-Identifier: MIT
// Replaces the hardware: simulates a Van der Pol oscillator (22) and a noisy sensor of its position. On a real rig
// measure() would read a sensor, and state() would not exist.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <random>

class VanDerPolRig {
 public:
  using State = std::array<double, 2>;  ///< position, velocity

  /// noise: standard deviation of the sensor, in the unit of the position.
  VanDerPolRig(double sample_period_s, double noise, std::uint64_t seed)
      : sample_period_s_(sample_period_s), noise_(noise), random_(seed) {
    restart();
  }

  /// Puts the oscillator into a random state of the box of the training.
  void restart() {
    std::uniform_real_distribution<double> box(-1.0, 1.0);
    for (double& x : state_) x = box(random_);
  }

  /// Simulates some sample periods and returns the measurement at their end.
  float measure(int periods) {
    for (int p = 0; p < periods; ++p) advance();
    return static_cast<float>(state_[0] + noise_ * standard_normal_(random_));
  }

  const State& state() const { return state_; }

 private:
  static State derivative(const State& x) { return {x[1], (1.0 - x[0] * x[0]) * x[1] - x[0]}; }
  static State moved(const State& x, double by_s, const State& slope) {
    return {x[0] + by_s * slope[0], x[1] + by_s * slope[1]};
  }

  /// Takes one step of the classical Runge-Kutta method.
  void advance() {
    const double h = sample_period_s_;
    const State a = derivative(state_);
    const State b = derivative(moved(state_, h / 2, a));
    const State c = derivative(moved(state_, h / 2, b));
    const State d = derivative(moved(state_, h, c));
    for (std::size_t i = 0; i < 2; ++i) state_[i] += h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
  }

  double sample_period_s_;
  double noise_;
  State state_{};
  std::mt19937_64 random_;
  std::normal_distribution<double> standard_normal_;
};
