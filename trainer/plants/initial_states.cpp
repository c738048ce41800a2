// SPDX-License-Identifier: MIT
#include "trainer/plants/initial_states.h"

#include <cmath>
#include <random>

namespace nlo::trainer {
namespace {

/// Steele, Lea & Flood, "Fast splittable pseudorandom number generators" (2014): neighbouring seeds end far apart.
std::uint64_t splitmix64(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}

double uniform01(std::mt19937_64& engine) {
  return static_cast<double>(engine() >> 11) * 0x1p-53;
}

double normal(std::mt19937_64& engine) {
  for (;;) {
    const double v1 = 2.0 * uniform01(engine) - 1.0, v2 = 2.0 * uniform01(engine) - 1.0;
    const double q = v1 * v1 + v2 * v2;
    if (q > 0.0 && q < 1.0) return v1 * std::sqrt(-2.0 * std::log(q) / q);
  }
}

}  // namespace

std::uint64_t initial_state_seed(std::uint64_t seed, SeedStream stream) {
  return splitmix64(seed + 0x9E3779B97F4A7C15u * (static_cast<std::uint64_t>(stream) + 1));
}

Eigen::MatrixXd draw_initial_states(const SimulationConfig& config, std::uint64_t engine_seed, Eigen::Index count,
                                    double box_scale) {
  std::mt19937_64 engine(engine_seed);
  const bool gaussian = config.initial_distribution == "gaussian";
  const auto nx = static_cast<Eigen::Index>(config.initial_low.size());
  Eigen::MatrixXd x(nx, count);
  for (Eigen::Index column = 0; column < count; ++column) {
    for (Eigen::Index i = 0; i < nx; ++i) {
      const double low = config.initial_low[static_cast<std::size_t>(i)];
      const double high = config.initial_high[static_cast<std::size_t>(i)];
      const double centre = 0.5 * (low + high), half_width = 0.5 * (high - low) * box_scale;
      x(i, column) = centre + half_width * (gaussian ? normal(engine) : 2.0 * uniform01(engine) - 1.0);
    }
  }
  return x;
}

}  // namespace nlo::trainer
