// SPDX-License-Identifier: MIT
// Lines with no more points than can be seen, so that the size of a figure does not grow with the length of the log.
#pragma once

#include <Eigen/Core>

namespace nlo::trainer {

struct Line {
  Eigen::VectorXd x, y;
};

/// Pixels per unit of each axis.
struct PixelScale {
  double x = 1.0, y = 1.0;
};

/// Points of the line (x, y), x increasing, that draw it:
///   of each half of a pixel's width the lowest and the highest, and a gap where it has one (y not finite);
///   of these the ones without which the line moves by more than 0.4 pixels (Douglas and Peucker), the ends
///   and the extremes of every piece in any case.
/// So no point of the line is a pixel away from the drawn line.
Line thinned_line(const Eigen::VectorXd& x, const Eigen::VectorXd& y, PixelScale scale);

}  // namespace nlo::trainer
