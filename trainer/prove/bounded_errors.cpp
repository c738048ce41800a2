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
    double largest = 0.0;  // all outputs share the largest V
    for (const SensorNoise& own : training.sensors) largest = std::max(largest, as_uniform(own));
    return largest == 0.0 ? kDefault : largest;
  }
  const NoiseConfig noise = parse_noise(text);
  if (noise.sensors.size() > 1)
    throw codegen::Error(fmt::format("--noise {}: the bound has one V for all outputs; give one noise", text));
  const SensorNoise& own = noise.sensors.front();
  if (own != SensorNoise{own.kind, own.scale, own.shape})
    throw codegen::Error(
        fmt::format("--noise {}: the bound is about bounded noise about zero; write uniform:HALF_WIDTH alone", text));
  if (!noise_row(own.kind).bounded())
    throw codegen::Error(
        fmt::format("--noise {}: this noise has no bound, and the bound is about bounded noise; write "
                    "uniform:{:.4g}, which is as strong",
                    text, as_uniform(own)));
  return as_uniform(own);
}

double disturbance_limit(const std::string& text) {
  const auto limit = finite_number(text);
  if (limit && *limit >= 0.0) return *limit;
  throw codegen::Error(fmt::format("--disturbance {}: must be a number from 0 on, the largest |w|", text));
}

}  // namespace nlo::trainer
