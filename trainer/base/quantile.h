// SPDX-License-Identifier: MIT
// Quantiles of a list by rank, without interpolation.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace nlo::trainer {

/// Computes value_at_rank() without a copy; it reorders `values`.
template <class T>
T value_at_rank_of(std::vector<T>& values, double q) {
  const auto at = values.begin() + std::lround(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Returns the quantile at 0 <= q <= 1 by the nearest rank; q = 0.5 is the median. `values` is not empty.
template <class T>
T value_at_rank(std::vector<T> values, double q) {
  return value_at_rank_of(values, q);
}

}  // namespace nlo::trainer
