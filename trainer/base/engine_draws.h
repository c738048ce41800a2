// SPDX-License-Identifier: MIT
// Random numbers from std::mt19937_64. The C++ standard fixes the numbers of this engine but not its distributions, so
// these are defined here.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

namespace nlo::trainer {

/// Returns a number uniform on [0, 1) with 53 bits.
inline double uniform01(std::mt19937_64& engine) {
  return static_cast<double>(engine() >> 11) * 0x1p-53;
}

/// Two independent standard normal numbers.
struct NormalPair {
  double first, second;
};

/// Draws a pair by Marsaglia's polar method, with the given logarithm.
template <class Log>
NormalPair normal_pair(std::mt19937_64& engine, const Log& log) {
  for (;;) {
    const double v1 = 2.0 * uniform01(engine) - 1.0, v2 = 2.0 * uniform01(engine) - 1.0;
    const double q = v1 * v1 + v2 * v2;
    if (!(q > 0.0 && q < 1.0)) continue;
    const double factor = std::sqrt(-2.0 * log(q) / q);
    return {v1 * factor, v2 * factor};
  }
}
inline NormalPair normal_pair(std::mt19937_64& engine) {
  return normal_pair(engine, [](double q) { return std::log(q); });
}

}  // namespace nlo::trainer
