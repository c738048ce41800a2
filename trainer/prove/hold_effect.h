// SPDX-License-Identifier: MIT
// The effect on z of reading held samples instead of y(t). Up to the third order of the sample period, the observer
// behaves as if it read another output, g. The remainder of fourth order has a bound.
#pragma once

#include <array>

#include "codegen/model/hold.h"

namespace nlo::trainer {

/// An observer that reads held samples moves like one without a hold that reads g instead of y:
///   F g = F (y + first L_f y + second L_f^2 y) + crossed D F L_f y
struct HoldEffect {
  double first = 0.0, second = 0.0, crossed = 0.0;  ///< [s], [s^2], [s^2]

  HoldEffect(Hold hold, double dt_s);

  /// Bounds the remainder of a mode's step, which has the fourth order in dt.
  ///   rates   sup |L_f^i y| for one output, i = 1, 2, 3
  ///   pushes  sup |d/dx L_f^i y w| for i = 0, 1, 2: the effect of a disturbance w on these rates
  static double left_over(Hold hold, double dt_s, double eigenvalue_size, const std::array<double, 3>& rates,
                          const std::array<double, 3>& pushes);
};

}  // namespace nlo::trainer
