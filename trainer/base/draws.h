// SPDX-License-Identifier: MIT
// Choices at random, the same on every platform: for searches, where a handful is drawn and speed does not matter.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "trainer/base/random.h"

namespace nlo::trainer {

/// To three digits, as a person would write it.
double rounded(double value);

class Draws {
 public:
  explicit Draws(std::uint64_t seed) : state_(seed) {}

  /// One of 0 ... count - 1. The remainder's bias is count / 2^64.
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(splitmix64(state_) % count); }

  double one_of(std::initializer_list<double> values) { return values.begin()[below(values.size())]; }

 private:
  std::uint64_t state_;
};

/// Other widths of hidden layers, in eights, and now and then a layer more or less.
void vary_widths(std::vector<int>& hidden, Draws& draws);

}  // namespace nlo::trainer
