// SPDX-License-Identifier: MIT
#include "trainer/prove/bounded_errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "codegen/base/error.h"
#include "trainer/base/noise_table.h"
#include "trainer/base/number_text.h"

namespace nlo::trainer {

double noise_limit(const std::string& text, const NoiseConfig& training) {
  constexpr double kDefault = 0.1;
  const auto as_uniform = [](const SensorNoise& own) {
    return own.scale * (noise_row(own.kind).bounded() ? noise_row(own.kind).largest
                                                      : std::sqrt(3.0 * noise_row(own.kind).variance));
  };
  if (text.empty()) {
    double largest = 0.0;  // one V for all outputs: the largest
    for (const SensorNoise& own : training.sensors) largest = std::max(largest, as_uniform(own));
    return largest == 0.0 ? kDefault : largest;
  }
  const NoiseConfig noise = parse_noise(text);
  if (noise.sensors.size() > 1)
    throw codegen::Error(fmt::format("--noise {}: the bound uses one V for all outputs; give a single noise", text));
  const SensorNoise& own = noise.sensors.front();
  if (own != SensorNoise{own.kind, own.scale, own.shape})
    throw codegen::Error(
        fmt::format("--noise {}: the bound needs bounded noise with mean zero; write only uniform:HALF_WIDTH", text));
  if (!noise_row(own.kind).bounded())
    throw codegen::Error(
        fmt::format("--noise {}: this noise is unbounded, but the proof needs bounded noise; write uniform:{:.4g}, "
                    "which has the same standard deviation",
                    text, as_uniform(own)));
  return as_uniform(own);
}

double disturbance_limit(const std::string& text) {
  const auto limit = finite_number(text);
  if (limit && *limit >= 0.0) return *limit;
  throw codegen::Error(fmt::format("--disturbance {}: must be a number of at least 0, the largest |w|", text));
}

}  // namespace nlo::trainer
