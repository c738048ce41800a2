// SPDX-License-Identifier: MIT
// Random choices for searches, the same on every platform. Few numbers are drawn, so speed does not matter.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "trainer/base/random.h"

namespace nlo::trainer {

/// Rounds to three significant digits.
double rounded(double value);

class Draws {
 public:
  explicit Draws(std::uint64_t seed) : state_(seed) {}

  /// Returns one of 0 ... count - 1. The bias of the remainder is count / 2^64.
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(splitmix64(state_) % count); }

  double one_of(std::initializer_list<double> values) { return values.begin()[below(values.size())]; }

 private:
  std::uint64_t state_;
};

/// Changes the widths of hidden layers, in multiples of eight; sometimes adds or removes a layer.
void vary_widths(std::vector<int>& hidden, Draws& draws);

}  // namespace nlo::trainer
