// SPDX-License-Identifier: MIT
// Reduces lines to the points that can be seen, so that the size of a figure does not grow with the length of the log.
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

/// Returns the points of the line (x, y), x increasing, that are needed to draw it. First it keeps the lowest and the
/// highest point of each half of a pixel's width, and gaps (y not finite). Of these it keeps the points without which
/// the line would move by more than 0.4 pixels (Douglas and Peucker), and always the ends and the extremes of every
/// piece. So no point of the line is a pixel away from the drawn line.
Line thinned_line(const Eigen::VectorXd& x, const Eigen::VectorXd& y, PixelScale scale);

}  // namespace nlo::trainer
