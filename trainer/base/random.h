// SPDX-License-Identifier: MIT
// Random numbers for training: many streams, eight at a time, the same on every platform. A stream is named by
// (seed, purpose, step, index) and carries no state from step to step, so a resumed run draws what an uninterrupted
// one would have drawn, on any number of threads.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "codegen/base/splitmix.h"
#include "nlo/kernels/simd.h"

namespace nlo::trainer {

using codegen::splitmix64;

/// What a stream is drawn for: streams of different purposes never meet.
enum class Purpose : std::uint64_t { kWeights = 1, kSegments, kTicks, kNoise, kValidationNoise, kOutages };

constexpr std::uint64_t stream_seed(std::uint64_t seed, Purpose purpose, std::uint64_t step, std::uint64_t index) {
  std::uint64_t state = seed;
  for (const std::uint64_t part : {static_cast<std::uint64_t>(purpose), step, index}) {
    state = splitmix64(state) ^ part * 0xd1342543de82ef95ULL;
  }
  return splitmix64(state);
}

/// Eight xoshiro128++ generators (Blackman, Vigna 2019) side by side, one SIMD operation for all of them.
class RandomLanes {
 public:
  static constexpr int kLanes = 8;
  using Floats = std::array<float, kLanes>;

  explicit RandomLanes(std::uint64_t seed) {
    for (auto& word : state_) {
      for (std::size_t l = 0; l < kLanes; l += 2) {
        const std::uint64_t bits = splitmix64(seed);
        word[l] = static_cast<std::uint32_t>(bits);
        word[l + 1] = static_cast<std::uint32_t>(bits >> 32);
      }
    }
  }

  /// Uniform on [0, 1), 24 bits.
  void uniform(float* out) {
    const Words bits = next() >> 8;
    for (int l = 0; l < kLanes; ++l) out[l] = static_cast<float>(static_cast<std::int32_t>(bits[l])) * 0x1p-24F;
  }

  /// Two independent standard normal numbers per lane, by Box and Muller's transform.
  void normal_pair(float* first, float* second) {
    float u[kLanes];
    float v[kLanes];
    uniform(u);
    uniform(v);
    for (int l = 0; l < kLanes; ++l) {
      const float radius = std::sqrt(-2.0F * log_positive(1.0F - u[l]));  // 1 - u in (0, 1]
      // cos and sin of 2 pi v: v = (q + f) / 4 with q whole and |f| <= 1/2.
      const float quarter = 4.0F * v[l];
      const auto q = static_cast<std::int32_t>(quarter + 0.5F);
      const float angle = (quarter - static_cast<float>(q)) * 1.57079633F;
      const float s2 = angle * angle;
      const float sine = angle * (1.0F + s2 * (-1.0F / 6 + s2 * (1.0F / 120 - s2 * (1.0F / 5040))));
      const float cosine = 1.0F + s2 * (-0.5F + s2 * (1.0F / 24 + s2 * (-1.0F / 720 + s2 * (1.0F / 40320))));
      const float a = (q & 1) != 0 ? -sine : cosine;
      const float b = (q & 1) != 0 ? cosine : sine;
      const float sign = (q & 2) != 0 ? -radius : radius;
      first[l] = sign * a;
      second[l] = sign * b;
    }
  }

 private:
  using Words = simd::Pack<std::uint32_t, kLanes>;

  static NLO_INLINE Words rotated_left(Words word, int bits) { return word << bits | word >> (32 - bits); }

  /// Compilers do not see by themselves that the lanes run side by side.
  NLO_INLINE Words next() {
    auto s0 = simd::load<Words>(state_[0].data()), s1 = simd::load<Words>(state_[1].data());
    auto s2 = simd::load<Words>(state_[2].data()), s3 = simd::load<Words>(state_[3].data());
    const Words result = rotated_left(s0 + s3, 7) + s0;
    const Words t = s1 << 9;
    s2 ^= s0;
    s3 ^= s1;
    s1 ^= s2;
    s0 ^= s3;
    s2 ^= t;
    simd::store(state_[0].data(), s0);
    simd::store(state_[1].data(), s1);
    simd::store(state_[2].data(), s2);
    simd::store(state_[3].data(), rotated_left(s3, 11));
    return result;
  }

  /// ln(x) for normal x > 0, relative error about 1e-7: exponent and mantissa, then 2 atanh((m - 1) / (m + 1)).
  static float log_positive(float x) {
    const std::int32_t bits = std::bit_cast<std::int32_t>(x);
    const std::int32_t exponent = (bits - 0x3f3504f3) >> 23;  // mantissa in [sqrt(1/2), sqrt(2))
    const float m = std::bit_cast<float>(bits - exponent * (1 << 23));
    const float s = (m - 1.0F) / (m + 1.0F);
    const float s2 = s * s;
    const float series = 2.0F * s * (1.0F + s2 * (1.0F / 3 + s2 * (1.0F / 5 + s2 * (1.0F / 7 + s2 * (1.0F / 9)))));
    return static_cast<float>(exponent) * 0.693147181F + series;
  }

  std::array<std::array<std::uint32_t, kLanes>, 4> state_;
};

}  // namespace nlo::trainer
