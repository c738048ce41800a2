// SPDX-License-Identifier: MIT
// Random bits for hostile flights: all numbers that a sensor, a storage or a bit flip may produce.
#pragma once

#include <cstdint>
#include <cstring>
#include <limits>

namespace nlo::hostile {

/// Source of bits for a flight: a generator (xorshift64*, Vigna 2016), or the bytes of a fuzzer.
class Bits {
 public:
  explicit Bits(std::uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15ULL + 1) {}
  Bits(const std::uint8_t* bytes, std::size_t size) : at_(bytes), end_(bytes + size) {}

  bool ended() const { return end_ != nullptr && at_ == end_; }

  /// Returns `bits` bits, 8 to 64, in whole bytes; zeros after the end of the fuzzer's bytes.
  std::uint64_t operator()(int bits) {
    if (end_ == nullptr) {
      state_ ^= state_ >> 12;
      state_ ^= state_ << 25;
      state_ ^= state_ >> 27;
      return (state_ * 0x2545f4914f6cdd1dULL) >> (64 - bits);
    }
    std::uint64_t value = 0;
    for (int i = 0; i < bits; i += 8)
      if (at_ < end_) value |= std::uint64_t{*at_++} << i;
    return value;
  }

  /// Flips a few bits of the memory, as damaged storage does.
  void corrupt(void* memory, std::size_t bytes) {
    auto* to = static_cast<unsigned char*>(memory);
    for (auto flips = (*this)(8) % 4; flips > 0; --flips) {
      const auto bit = (*this)(16);
      unsigned char& byte = to[bit / 8 % bytes];
      byte = static_cast<unsigned char>(byte ^ (1U << (bit % 8)));
    }
  }

 private:
  std::uint64_t state_ = 0;
  const std::uint8_t *at_ = nullptr, *end_ = nullptr;
};

/// Returns a number for a sensor with the range [low, high]: mostly within, sometimes beyond, sometimes any bits.
template <class Scalar>
Scalar reading(Bits& bits, Scalar low, Scalar high) {
  using Limits = std::numeric_limits<Scalar>;
  constexpr Scalar kSpecial[] = {
      Scalar(0),          -Scalar(0),          Limits::denorm_min(), -Limits::min(),  Limits::max(), Limits::lowest(),
      Limits::infinity(), -Limits::infinity(), Limits::quiet_NaN(),  Scalar(0x1p100), Scalar(1),     Scalar(-1e30)};
  const auto kind = bits(8);
  if (kind < 24) {
    const std::uint64_t any = bits(8 * sizeof(Scalar));
    Scalar value;
    std::memcpy(&value, &any, sizeof(value));  // the lower bytes on a little-endian machine
    return value;
  }
  if (kind < 36) return kSpecial[kind - 24];
  if (kind < 40) return kind % 2 == 0 ? low : high;
  const auto share = static_cast<Scalar>(bits(16)) / Scalar(65535);
  return (low * (Scalar(1) - share) + high * share) * (kind < 56 ? Scalar(2) : Scalar(1));
}

}  // namespace nlo::hostile
