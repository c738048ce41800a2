// SPDX-License-Identifier: MIT
// A batch of plants, compared with as many single observers with the same measurements.
#pragma once

#include <nlo/vector.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "tests/runtime/testing.h"

namespace nlo::testing {

/// Returns the largest difference of z, readings and x_hat between a batch and kPlants observers that start as `fresh`.
/// Statuses of plants and channels, and the domain, must be equal at each sample. `reading(sample, plant, channel)`
/// returns the reading of a channel, outputs before inputs.
template <int kPlants, class Batch, class Observer, class Reading>
float off_observers(Batch&& batch, const Observer& fresh, Reading reading) {
  constexpr int kNy = Observer::kNy, kNu = Observer::kNu, kNx = Observer::kNx;
  float worst_off = 0.0F;
  const auto compare = [&worst_off](float got, float want) {
    const float off = std::fabs(got - want);
    if (!(off <= worst_off)) worst_off = off > 0.0F ? off : std::numeric_limits<float>::infinity();
  };
  std::vector<Observer> observers(kPlants, fresh);
  for (int sample = 0; sample < 60; ++sample) {
    float y[kNy][kPlants], u[kNu == 0 ? 1 : kNu][kPlants], x_hat[kNx][kPlants];
    StepStatus worst = StepStatus::kOk, status;
    for (int n = 0; n < kPlants; ++n) {
      typename Observer::Output outputs{};
      for (int j = 0; j < kNy; ++j) outputs[j] = y[j][n] = reading(sample, n, j);
      auto& observer = observers[static_cast<std::size_t>(n)];
      if constexpr (kNu == 0) {
        worst = std::max(worst, observer.step(outputs));
      } else {
        typename Observer::Input inputs{};
        for (int i = 0; i < kNu; ++i) inputs[i] = u[i][n] = reading(sample, n, kNy + i);
        worst = std::max(worst, observer.step(outputs, inputs));
      }
    }
    if constexpr (kNu == 0) {
      status = batch.step(y);
    } else {
      status = batch.step(y, u);
    }
    EXPECT_EQ(status, worst) << "sample " << sample;
    batch.estimate(x_hat);
    for (int n = 0; n < kPlants; ++n) {
      const Observer& observer = observers[static_cast<std::size_t>(n)];
      EXPECT_EQ(batch.status(n), observer.status()) << "plant " << n << ", sample " << sample;
      for (int j = -1; j <= kNy + kNu; ++j)
        EXPECT_EQ(batch.status(n, j), observer.status(j)) << "channel " << j << " of plant " << n;
      EXPECT_EQ(batch.in_domain(n), observer.in_domain()) << "plant " << n << ", sample " << sample;
      const auto got = batch.save(n), want = observer.save();
      for (int r = 0; r < Observer::kNz; ++r) compare(got.z[r], want.z[r]);
      for (int j = 0; j < Observer::kNr; ++j) compare(got.y[j], want.y[j]);
      for (int i = 0; i < kNx; ++i) compare(x_hat[i][n], observer.estimate()[i]);
    }
  }
  return worst_off;
}

/// Measurements of each kind: good, missing, outside of the range +-1, infinite; some plants start late. Sometimes all
/// plants have good measurements, which uses the fast path.
class AnyMeasurement {
 public:
  float operator()(int sample, int plant, int /*channel*/) {
    if (sample % 3 == 2) return 0.1F * static_cast<float>(plant % 9) - 0.4F;
    if (sample < plant % 4) return std::numeric_limits<float>::quiet_NaN();  // this plant starts later than the others
    const float y = uniform<float>(random_, -0.9, 0.9);
    if (uniform<float>(random_, 0, 1) < 0.9F) return y;
    const float bad[] = {y, std::numeric_limits<float>::quiet_NaN(), 5.0F, -std::numeric_limits<float>::infinity()};
    return bad[random_() % 4];
  }

 private:
  std::mt19937 random_{7};
};

}  // namespace nlo::testing
