// SPDX-License-Identifier: MIT
#include "codegen/model/flight.h"

#include <algorithm>
#include <cmath>

namespace nlo::codegen {

double flight_step(double range, double largest) {
  constexpr double kSensorCounts = 0x1p14;
  const double step = std::max(range / kSensorCounts, largest / kMostFlightCount);
  constexpr double kSmallest = 0x1p-100;  // a normal float
  return step > kSmallest ? std::exp2(std::ceil(std::log2(step))) : kSmallest;
}

}  // namespace nlo::codegen
