// SPDX-License-Identifier: MIT
#include "codegen/base/vlq.h"

#include <cstdint>
#include <cstdlib>
#include <vector>

namespace nlo::codegen {
namespace {

constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
constexpr int kBits = 5;
constexpr std::uint64_t kMore = 1U << kBits;

}  // namespace

std::string to_vlq(const Eigen::VectorXi& values) {
  std::string text;
  std::int64_t before = 0;
  for (const int value : values) {
    const std::int64_t difference = value - before;
    auto bits = static_cast<std::uint64_t>(std::abs(difference)) << 1 | (difference < 0 ? 1U : 0U);
    before = value;
    do {
      const std::uint64_t digit = bits % kMore;
      bits >>= kBits;
      text += kDigits[digit | (bits > 0 ? kMore : 0)];
    } while (bits > 0);
  }
  return text;
}

std::optional<Eigen::VectorXi> from_vlq(std::string_view text, int most) {
  constexpr int kLongest = 35;  // bits of a difference of two 32-bit integers, sign included, in whole characters
  std::vector<int> values;
  std::int64_t value = 0;
  std::uint64_t bits = 0;
  int shift = 0;
  for (const char c : text) {
    const std::size_t digit = kDigits.find(c);
    if (digit == std::string_view::npos || shift >= kLongest) return std::nullopt;
    bits |= (digit % kMore) << shift;
    shift += kBits;
    if ((digit & kMore) != 0) continue;
    const auto size = static_cast<std::int64_t>(bits >> 1);
    value += (bits & 1) != 0 ? -size : size;
    if (std::abs(value) > most) return std::nullopt;
    values.push_back(static_cast<int>(value));
    bits = 0;
    shift = 0;
  }
  if (shift != 0) return std::nullopt;
  return Eigen::Map<const Eigen::VectorXi>(values.data(), static_cast<Eigen::Index>(values.size()));
}

}  // namespace nlo::codegen
