// SPDX-License-Identifier: MIT
#include "trainer/prove/hold_effect.h"

#include <cmath>

namespace nlo::trainer {

HoldEffect::HoldEffect(Hold hold, double dt_s) {
  // The held reading minus y, averaged over a step: from -s for a zero-order hold, and from s (dt - s) / 2 for a line
  // between samples.
  second = dt_s * dt_s / 12.0;
  if (hold != Hold::kZeroOrder) return;
  first = -0.5 * dt_s;
  crossed = second;
}

double HoldEffect::left_over(Hold hold, double dt_s, double eigenvalue_size, const std::array<double, 3>& rates,
                             const std::array<double, 3>& pushes) {
  // Taylor's remainders, integrated over a step; .0321 = integral of |s (1 - s) / 2 - 1 / 12| over [0, 1].
  const double l = eigenvalue_size, fourth = std::pow(dt_s, 4);
  const double pushed = dt_s * dt_s * (pushes[0] + dt_s * (pushes[1] + dt_s * pushes[2]));
  if (hold != Hold::kZeroOrder) return fourth * (rates[2] / 6.0 + 0.0161 * l * rates[1]) + pushed;
  return fourth * (rates[2] / 6.0 + 0.0738 * l * rates[1] + 0.0886 * l * l * rates[0]) + pushed;
}

}  // namespace nlo::trainer
