// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

namespace nlo::trainer {

/// Weighted mean and deviation, one pass (West 1979).
struct Moments {
  double total = 0.0, mean = 0.0, squares = 0.0;
  void add(double x, double w) {
    if (w <= 0.0) return;
    total += w;
    const double step = x - mean;
    mean += step * w / total;
    squares += w * step * (x - mean);
  }
  double deviation() const { return total > 0.0 ? std::sqrt(squares / total) : 0.0; }
};

/// Returns a scale by which one can divide: 1 for a constant signal.
inline float safe_scale(double deviation) {
  return deviation > 1e-9 ? static_cast<float>(deviation) : 1.0F;
}

}  // namespace nlo::trainer
