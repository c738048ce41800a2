// SPDX-License-Identifier: MIT
// Values of sampled signals between their samples. Beyond either end the signal keeps its last value.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace nlo::trainer {

/// Returns the value on the straight line between the samples around `position`, in samples from the first. For an
/// input that is held between samples, this is its mean over the sample period shifted by the same time.
///   values  values(i) for 0 <= i < count
template <class Scalar, class Values>
Scalar linear_at(const Values& values, std::ptrdiff_t count, double position) {
  const double inside = std::clamp(position, 0.0, static_cast<double>(count - 1));
  const auto before = static_cast<std::ptrdiff_t>(inside);
  const auto share = static_cast<Scalar>(inside - static_cast<double>(before));
  if (share == Scalar(0)) return values(before);
  return values(before) + share * (values(before + 1) - values(before));
}

/// Returns the value of the cubic through the four samples around `position`, if there are four. For a sinusoid with 20
/// samples a period its error is below 3e-4 of the amplitude; that of the straight line is 1.2e-2.
template <class Scalar, class Values>
Scalar cubic_at(const Values& values, std::ptrdiff_t count, double position) {
  const double inside = std::clamp(position, 0.0, static_cast<double>(count - 1));
  const auto i = static_cast<std::ptrdiff_t>(inside);
  const auto t = static_cast<Scalar>(inside - static_cast<double>(i));
  if (i < 1 || i + 2 >= count || t == Scalar(0)) return linear_at<Scalar>(values, count, inside);
  const Scalar below = t + Scalar(1), above = Scalar(1) - t, beyond = Scalar(2) - t;
  return Scalar(0.5) * (below * above * beyond * values(i) + below * t * beyond * values(i + 1)) -
         (t * above * beyond * values(i - 1) + below * t * above * values(i + 2)) / Scalar(6);
}

}  // namespace nlo::trainer
