// SPDX-License-Identifier: MIT
// The random numbers of the training are uniform and normal, to the resolution of ten million draws.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "trainer/base/random.h"

namespace nlo::trainer {
namespace {

constexpr std::uint64_t kSeed = 20261121;

/// Raw moments and a histogram of draws over [-kReach, kReach).
class Sample {
 public:
  static constexpr int kBins = 4096;
  static constexpr double kReach = 8.0;
  void add(double x) {
    ++count;
    double power = 1.0;
    for (double& moment : sums_) moment += power *= x;
    largest = std::max(largest, std::abs(x));
    finite = finite && std::isfinite(x);
    if (std::abs(x) < kReach) ++bins_[static_cast<std::size_t>((x + kReach) / (2.0 * kReach) * kBins)];
  }
  double moment(int order) const { return sums_[static_cast<std::size_t>(order - 1)] / static_cast<double>(count); }
  /// Largest distance of the distribution function from `cdf`, over the edges of the bins.
  template <class Cdf>
  double kolmogorov_smirnov(const Cdf& cdf) const {
    double below = 0.0;
    double distance = 0.0;
    for (int b = 0; b < kBins; ++b) {
      below += static_cast<double>(bins_[static_cast<std::size_t>(b)]);
      const double edge = -kReach + 2.0 * kReach * (b + 1) / kBins;
      distance = std::max(distance, std::abs(below / static_cast<double>(count) - cdf(edge)));
    }
    return distance;
  }
  long count = 0;
  double largest = 0.0;
  bool finite = true;

 private:
  double sums_[4] = {};
  std::vector<long> bins_ = std::vector<long>(kBins, 0);
};

double normal_cdf(double x) {
  return 0.5 * std::erfc(-x / std::numbers::sqrt2);
}
double uniform_cdf(double x) {
  return std::clamp(x, 0.0, 1.0);
}

/// The distance that a fair sample exceeds with probability 1e-4 (Kolmogorov's distribution, 2.23 / sqrt(n)).
double kolmogorov_smirnov_limit(long count) {
  return 2.23 / std::sqrt(static_cast<double>(count));
}

// Limit in standard errors of a moment: a fair generator exceeds it once in 2e6 seeds, and the seed is fixed.
constexpr double kSigmas = 5.0;

TEST(RandomLanes, UniformNumbersAreUniformOnZeroToOne) {
  Sample sample;
  RandomLanes random(kSeed);
  bool in_range = true;
  for (int draw = 0; draw < 250'000; ++draw) {
    RandomLanes::Floats u{};
    random.uniform(u.data());
    for (const float x : u) {
      sample.add(static_cast<double>(x));
      in_range = in_range && x >= 0.0F && x < 1.0F;
    }
  }
  const double root_n = std::sqrt(static_cast<double>(sample.count));
  EXPECT_TRUE(in_range);
  EXPECT_NEAR(sample.moment(1), 0.5, kSigmas * std::sqrt(1.0 / 12.0) / root_n);
  EXPECT_NEAR(sample.moment(2), 1.0 / 3.0, kSigmas * std::sqrt(4.0 / 45.0) / root_n);
  EXPECT_LT(sample.kolmogorov_smirnov(uniform_cdf), kolmogorov_smirnov_limit(sample.count));
  EXPECT_GT(sample.kolmogorov_smirnov([](double x) { return uniform_cdf(x * 0.99); }),
            kolmogorov_smirnov_limit(sample.count))
      << "control: the distance detects a stretch by one percent";
}

TEST(RandomLanes, TenMillionNormalNumbersHaveTheMomentsTheDistributionAndTheTailsOfANormal) {
  Sample sample;
  long beyond_three = 0;
  long beyond_four = 0;
  RandomLanes random(kSeed);
  for (int draw = 0; draw < 625'000; ++draw) {
    RandomLanes::Floats pair[2]{};
    random.normal_pair(pair[0].data(), pair[1].data());
    for (const auto& half : pair) {
      for (const float x : half) {
        sample.add(static_cast<double>(x));
        beyond_three += std::abs(x) > 3.0F ? 1 : 0;
        beyond_four += std::abs(x) > 4.0F ? 1 : 0;
      }
    }
  }
  ASSERT_EQ(sample.count, 10'000'000);
  const auto n = static_cast<double>(sample.count);
  EXPECT_TRUE(sample.finite);
  EXPECT_NEAR(sample.moment(1), 0.0, kSigmas / std::sqrt(n));
  EXPECT_NEAR(sample.moment(2), 1.0, kSigmas * std::sqrt(2.0 / n));
  EXPECT_NEAR(sample.moment(3), 0.0, kSigmas * std::sqrt(15.0 / n));
  EXPECT_NEAR(sample.moment(4), 3.0, kSigmas * std::sqrt(96.0 / n));
  EXPECT_LT(sample.kolmogorov_smirnov(normal_cdf), kolmogorov_smirnov_limit(sample.count));
  EXPECT_GT(sample.kolmogorov_smirnov([](double x) { return normal_cdf(x * 1.01); }),
            kolmogorov_smirnov_limit(sample.count))
      << "control: the distance detects a deviation of 0.99";
  const double three = 2.0 * normal_cdf(-3.0) * n;
  const double four = 2.0 * normal_cdf(-4.0) * n;
  EXPECT_NEAR(static_cast<double>(beyond_three), three, kSigmas * std::sqrt(three));
  EXPECT_NEAR(static_cast<double>(beyond_four), four, kSigmas * std::sqrt(four));
  // u has 24 bits: the largest radius is sqrt(2 ln 2^24) = 5.768, which occurs once in 2^24 pairs.
  EXPECT_LT(sample.largest, 5.77);
  EXPECT_GT(sample.largest, 4.8);
}

TEST(RandomLanes, NormalNumbersOfPairsLanesAndDrawsAreIndependent) {
  constexpr int kDraws = 200'000;
  RandomLanes random(kSeed + 1);
  double products[5] = {};
  RandomLanes::Floats last{};
  for (int draw = 0; draw < kDraws; ++draw) {
    RandomLanes::Floats first{};
    RandomLanes::Floats second{};
    random.normal_pair(first.data(), second.data());
    for (std::size_t l = 0; l < first.size(); ++l) {
      const auto a = static_cast<double>(first[l]);
      const auto b = static_cast<double>(second[l]);
      const auto neighbour = static_cast<double>(first[(l + 1) % first.size()]);
      products[0] += a * b;
      products[1] += (a * a - 1.0) * (b * b - 1.0) / 2.0;  // large if both share a radius
      products[2] += a * (b * b - 1.0) / std::numbers::sqrt2;
      products[3] += a * neighbour;
      products[4] += a * static_cast<double>(last[l]);
    }
    last = first;
  }
  // Each product has mean 0 and variance at most 2 when its factors are independent.
  const double limit = kSigmas * std::numbers::sqrt2 / std::sqrt(8.0 * kDraws);
  for (const double sum : products) EXPECT_LT(std::abs(sum / (8.0 * kDraws)), limit);
}

/// Box and Muller's transform in double, from the uniform numbers that a copy of the generator gives.
void expect_box_muller(RandomLanes random) {
  // ln and the polynomials of sine and cosine (|angle| <= pi/4) are good to 3e-7, times a radius of at most 5.8.
  constexpr double kTolerance = 4e-6;
  RandomLanes copy = random;
  RandomLanes::Floats u{};
  RandomLanes::Floats v{};
  copy.uniform(u.data());
  copy.uniform(v.data());
  RandomLanes::Floats first{};
  RandomLanes::Floats second{};
  random.normal_pair(first.data(), second.data());
  for (std::size_t l = 0; l < u.size(); ++l) {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - static_cast<double>(u[l])));
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(v[l]);
    ASSERT_NEAR(static_cast<double>(first[l]), radius * std::cos(angle), kTolerance) << "u " << u[l] << " v " << v[l];
    ASSERT_NEAR(static_cast<double>(second[l]), radius * std::sin(angle), kTolerance) << "u " << u[l] << " v " << v[l];
  }
}

TEST(RandomLanes, NormalNumbersAreBoxAndMullersTransform) {
  RandomLanes random(kSeed + 2);
  for (int draw = 0; draw < 20'000; ++draw) {
    expect_box_muller(random);
    if (HasFatalFailure()) return;
    RandomLanes::Floats skip{};
    random.uniform(skip.data());
  }
}

TEST(RandomLanes, DrawingManyPairsEqualsDrawingThemOneByOne) {
  for (int pairs = 0; pairs <= 9; ++pairs) {
    RandomLanes together(kSeed + 3), alone(kSeed + 3);
    std::vector<RandomLanes::Floats> many(static_cast<std::size_t>(2 * pairs) + 1), one(many.size());
    together.normal_pairs(many[0].data(), pairs);
    for (std::size_t p = 0; p < 2 * static_cast<std::size_t>(pairs); p += 2)
      alone.normal_pair(one[p].data(), one[p + 1].data());
    together.uniform(many.back().data());
    alone.uniform(one.back().data());
    EXPECT_EQ(many, one) << pairs;
  }
}

TEST(RandomLanes, NormalNumbersAreFiniteForTheSmallestAndLargestUniformNumber) {
  // A search found these seeds, whose first draw is the smallest or the largest number. Only one seed in 2^21 has such
  // a draw.
  bool zero = false;
  bool one = false;
  for (std::uint64_t seed = 0; seed < (1U << 26) && !(zero && one); ++seed) {
    RandomLanes random(seed);
    RandomLanes copy = random;
    RandomLanes::Floats u{};
    copy.uniform(u.data());
    float low = u[0];
    float high = u[0];
    for (const float x : u) {
      low = std::min(low, x);
      high = std::max(high, x);
    }
    if (low != 0.0F && high != 1.0F - 0x1p-24F) continue;
    zero = zero || low == 0.0F;
    one = one || high == 1.0F - 0x1p-24F;
    expect_box_muller(random);
  }
  EXPECT_TRUE(zero && one);
}

}  // namespace
}  // namespace nlo::trainer
