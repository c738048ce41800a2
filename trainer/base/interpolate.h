// SPDX-License-Identifier: MIT
// Sampled signals between their samples. Beyond either end the signal keeps its last value.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace nlo::trainer {

/// The straight line between the samples around `position`, in samples from the first. Of an input that is held between
/// samples this is its mean over the sample period that is shifted by as much.
///   values  values(i) of 0 <= i < count
template <class Scalar, class Values>
Scalar linear_at(const Values& values, std::ptrdiff_t count, double position) {
  const double inside = std::clamp(position, 0.0, static_cast<double>(count - 1));
  const auto before = static_cast<std::ptrdiff_t>(inside);
  const auto share = static_cast<Scalar>(inside - static_cast<double>(before));
  if (share == Scalar(0)) return values(before);
  return values(before) + share * (values(before + 1) - values(before));
}

/// The cubic through the four samples around `position`, where there are four: of a sinusoid of 20 samples a period off
/// by less than 3e-4 of its amplitude, where the line is off by 1.2e-2.
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
