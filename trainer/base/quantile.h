// SPDX-License-Identifier: MIT
// Quantiles of a list by rank: one of its values, none between two.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace nlo::trainer {

/// As value_at_rank(), without a copy: `values` change their order.
template <class T>
T value_at_rank_of(std::vector<T>& values, double q) {
  const auto at = values.begin() + std::lround(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// The value at the share `q` of the way from the smallest to the largest, 0 <= q <= 1, to the nearest rank; q = 0.5 is
/// the median. `values` is not empty.
template <class T>
T value_at_rank(std::vector<T> values, double q) {
  return value_at_rank_of(values, q);
}

}  // namespace nlo::trainer
