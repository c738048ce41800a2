// SPDX-License-Identifier: MIT
#include "trainer/base/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

namespace nlo::trainer {
namespace {

/// xoshiro128++ as published by its authors: one scalar generator.
class PlainXoshiro {
 public:
  explicit PlainXoshiro(std::array<std::uint32_t, 4> state) : s_(state) {}
  std::uint32_t next() {
    const auto rotated = [](std::uint32_t x, int k) { return (x << k) | (x >> (32 - k)); };
    const std::uint32_t result = rotated(s_[0] + s_[3], 7) + s_[0];
    const std::uint32_t t = s_[1] << 9;
    s_[2] ^= s_[0];
    s_[3] ^= s_[1];
    s_[1] ^= s_[2];
    s_[0] ^= s_[3];
    s_[2] ^= t;
    s_[3] = rotated(s_[3], 11);
    return result;
  }

 private:
  std::array<std::uint32_t, 4> s_;
};

constexpr std::uint64_t kSeed = 20261121;

TEST(SplitMix64, GivesThePublishedSequence) {
  std::uint64_t state = 1234567;
  for (const std::uint64_t expected : {6457827717110365317ULL, 3203168211198807973ULL, 9817491932198370423ULL,
                                       4593380528125082431ULL, 16408922859458223821ULL}) {
    EXPECT_EQ(splitmix64(state), expected);
  }
}

TEST(RandomLanes, ReferenceGeneratorOfThisTestGivesThePublishedSequence) {
  PlainXoshiro plain({1, 2, 3, 4});
  for (const std::uint32_t expected : {641U, 1573767U, 3222811527U, 3517856514U, 836907274U, 4247214768U, 3867114732U,
                                       1355841295U, 495546011U, 621204420U}) {
    EXPECT_EQ(plain.next(), expected);
  }
}

TEST(RandomLanes, AreEightXoshiro128PlusPlusGeneratorsSeededBySplitMix64) {
  std::array<std::array<std::uint32_t, 4>, RandomLanes::kLanes> states{};
  std::uint64_t seed = kSeed;
  for (std::size_t word = 0; word < 4; ++word) {
    for (std::size_t lane = 0; lane < RandomLanes::kLanes; lane += 2) {
      const std::uint64_t bits = splitmix64(seed);
      states[lane][word] = static_cast<std::uint32_t>(bits & 0xffffffffU);
      states[lane + 1][word] = static_cast<std::uint32_t>(bits >> 32);
    }
  }
  std::vector<PlainXoshiro> plain(states.begin(), states.end());
  RandomLanes lanes(kSeed);
  for (int draw = 0; draw < 1000; ++draw) {
    RandomLanes::Floats u{};
    lanes.uniform(u.data());
    for (std::size_t lane = 0; lane < u.size(); ++lane) {
      ASSERT_EQ(u[lane], static_cast<float>(plain[lane].next() >> 8) / 16777216.0F) << "draw " << draw;
    }
  }
}

TEST(StreamSeed, ChangesWithEachOfItsParts) {
  std::set<std::uint64_t> seeds;
  std::size_t count = 0;
  for (const std::uint64_t seed : {0ULL, 1ULL, 2ULL}) {
    for (const Purpose purpose :
         {Purpose::kWeights, Purpose::kSegments, Purpose::kTicks, Purpose::kNoise, Purpose::kValidationNoise}) {
      for (std::uint64_t step = 0; step < 100; ++step) {
        for (std::uint64_t index = 0; index < 20; ++index, ++count) {
          seeds.insert(stream_seed(seed, purpose, step, index));
        }
      }
    }
  }
  EXPECT_EQ(seeds.size(), count);
}

TEST(StreamSeed, NeighbouringStreamsAreUncorrelated) {
  constexpr int kDraws = 100'000;
  // The correlation of independent numbers has a standard deviation of 1 / sqrt(draws). It never exceeds five of these.
  const double limit = 5.0 / std::sqrt(8.0 * kDraws);
  RandomLanes base(stream_seed(1, Purpose::kNoise, 7, 3));
  RandomLanes others[] = {
      RandomLanes(stream_seed(2, Purpose::kNoise, 7, 3)), RandomLanes(stream_seed(1, Purpose::kTicks, 7, 3)),
      RandomLanes(stream_seed(1, Purpose::kNoise, 8, 3)), RandomLanes(stream_seed(1, Purpose::kNoise, 7, 4))};
  double sums[4] = {};
  for (int draw = 0; draw < kDraws; ++draw) {
    RandomLanes::Floats a{};
    base.uniform(a.data());
    for (std::size_t o = 0; o < 4; ++o) {
      RandomLanes::Floats b{};
      others[o].uniform(b.data());
      for (std::size_t l = 0; l < a.size(); ++l) {
        sums[o] += 12.0 * (static_cast<double>(a[l]) - 0.5) * (static_cast<double>(b[l]) - 0.5);
      }
    }
  }
  for (const double sum : sums) EXPECT_LT(std::abs(sum / (8.0 * kDraws)), limit);
}

}  // namespace
}  // namespace nlo::trainer
