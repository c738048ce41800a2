// SPDX-License-Identifier: MIT
// The last steps of a noisy sensor: it clips a value, then rounds it to steps.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "trainer/base/noise.h"

namespace nlo::trainer {

inline bool clips_or_rounds(const SensorNoise& sensor) {
  return sensor.limit > 0.0 || sensor.quantum > 0.0;
}

/// Returns the value clipped to +-SensorNoise::limit and rounded to a multiple of SensorNoise::quantum.
template <class Scalar>
Scalar reading_of(const SensorNoise& sensor, Scalar value) {
  const auto limit = static_cast<Scalar>(sensor.limit), quantum = static_cast<Scalar>(sensor.quantum);
  if (limit > Scalar(0)) value = std::clamp(value, -limit, limit);
  if (quantum > Scalar(0)) value = quantum * std::round(value / quantum);
  return value;
}

/// Replaces the sine and the cosine of an angle by those of the reading of its angle, which is between -wrap/2 and
/// wrap/2. A NaN stays NaN.
///   wrap  full turn of the angle, in the unit of the sensor
template <class Scalar>
void read_angle(const SensorNoise& sensor, double wrap, Scalar& sine, Scalar& cosine) {
  const auto unit = static_cast<Scalar>(wrap / (2.0 * std::numbers::pi));
  const Scalar angle = reading_of(sensor, unit * std::atan2(sine, cosine)) / unit;
  sine = std::sin(angle);
  cosine = std::cos(angle);
}

}  // namespace nlo::trainer
