// SPDX-License-Identifier: MIT
// Random numbers for training: many streams, eight at a time, the same on every platform. A stream is named by
// (seed, purpose, step, index) and carries no state from step to step, so a resumed run draws the same numbers as an
// uninterrupted one, on any number of threads.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "codegen/base/splitmix.h"
#include "nlo/kernels/simd.h"

namespace nlo::trainer {

using codegen::splitmix64;

/// The purpose of a stream. Streams of different purposes are independent.
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

  /// Draws uniform numbers on [0, 1) with 24 bits.
  void uniform(float* out) {
    Generator generator(state_);
    generator.uniform(out);
  }

  /// Draws two independent standard normal numbers per lane, by Box and Muller's transform.
  void normal_pair(float* first, float* second) {
    float u[kLanes];
    float v[kLanes];
    Generator generator(state_);
    generator.uniform(u);
    generator.uniform(v);
    for (int l = 0; l < kLanes; ++l) box_muller(u[l], v[l], first[l], second[l]);
  }

  /// Draws `pairs` pairs to out: first, second, first, second...
  void normal_pairs(float* out, int pairs) {
    constexpr int kTogether = 4;  // enough for wide registers
    Generator generator(state_);
    float u[kTogether * kLanes] = {}, v[kTogether * kLanes] = {};
    float first[kTogether * kLanes], second[kTogether * kLanes];
    for (int done = 0; done < pairs; done += kTogether) {
      const int count = std::min(kTogether, pairs - done);
      for (int p = 0; p < count; ++p) {
        generator.uniform(u + p * kLanes);
        generator.uniform(v + p * kLanes);
      }
      // All rounds compute all numbers, because fused products depend on how a loop is compiled.
      for (int i = 0; i < kTogether * kLanes; ++i) box_muller(u[i], v[i], first[i], second[i]);
      for (int p = 0; p < count; ++p, out += 2 * kLanes) {
        std::copy_n(first + p * kLanes, kLanes, out);
        std::copy_n(second + p * kLanes, kLanes, out + kLanes);
      }
    }
  }

 private:
  using Words = simd::Pack<std::uint32_t, kLanes>;
  using State = std::array<std::array<std::uint32_t, kLanes>, 4>;

  /// Keeps the state in registers until it is written back.
  class Generator {
   public:
    explicit Generator(State& state) : state_(state) {
      for (std::size_t i = 0; i < 4; ++i) s_[i] = simd::load<Words>(state[i].data());
    }
    ~Generator() {
      for (std::size_t i = 0; i < 4; ++i) simd::store(state_[i].data(), s_[i]);
    }
    Generator(const Generator&) = delete;
    Generator& operator=(const Generator&) = delete;

    NLO_INLINE void uniform(float* out) {
      const Words bits = next() >> 8;
      for (int l = 0; l < kLanes; ++l) out[l] = static_cast<float>(static_cast<std::int32_t>(bits[l])) * 0x1p-24F;
    }

   private:
    static NLO_INLINE Words rotated_left(Words word, int bits) { return word << bits | word >> (32 - bits); }

    /// Written by hand, because compilers do not see that the lanes are independent.
    NLO_INLINE Words next() {
      const Words result = rotated_left(s_[0] + s_[3], 7) + s_[0];
      const Words t = s_[1] << 9;
      s_[2] ^= s_[0];
      s_[3] ^= s_[1];
      s_[1] ^= s_[2];
      s_[0] ^= s_[3];
      s_[2] ^= t;
      s_[3] = rotated_left(s_[3], 11);
      return result;
    }

    State& state_;
    Words s_[4];
  };

  static NLO_INLINE void box_muller(float u, float v, float& first, float& second) {
    const float radius = std::sqrt(-2.0F * log_positive(1.0F - u));  // 1 - u in (0, 1]
    // cos and sin of 2 pi v: v = (q + f) / 4 with an integer q and |f| <= 1/2.
    const float quarter = 4.0F * v;
    const auto q = static_cast<std::int32_t>(quarter + 0.5F);
    const float angle = (quarter - static_cast<float>(q)) * 1.57079633F;
    const float s2 = angle * angle;
    const float sine = angle * (1.0F + s2 * (-1.0F / 6 + s2 * (1.0F / 120 - s2 * (1.0F / 5040))));
    const float cosine = 1.0F + s2 * (-0.5F + s2 * (1.0F / 24 + s2 * (-1.0F / 720 + s2 * (1.0F / 40320))));
    const float a = (q & 1) != 0 ? -sine : cosine;
    const float b = (q & 1) != 0 ? cosine : sine;
    const float sign = (q & 2) != 0 ? -radius : radius;
    first = sign * a;
    second = sign * b;
  }

  /// Returns ln(x) for normal x > 0, relative error about 1e-7: exponent and mantissa, then 2 atanh((m - 1) / (m + 1)).
  static float log_positive(float x) {
    const std::int32_t bits = std::bit_cast<std::int32_t>(x);
    const std::int32_t exponent = (bits - 0x3f3504f3) >> 23;  // mantissa in [sqrt(1/2), sqrt(2))
    const float m = std::bit_cast<float>(bits - exponent * (1 << 23));
    const float s = (m - 1.0F) / (m + 1.0F);
    const float s2 = s * s;
    const float series = 2.0F * s * (1.0F + s2 * (1.0F / 3 + s2 * (1.0F / 5 + s2 * (1.0F / 7 + s2 * (1.0F / 9)))));
    return static_cast<float>(exponent) * 0.693147181F + series;
  }

  State state_;
};

}  // namespace nlo::trainer
