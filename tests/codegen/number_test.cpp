// SPDX-License-Identifier: MIT
#include "codegen/base/number.h"

#include <gtest/gtest.h>

#include <bit>
#include <charconv>
#include <clocale>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>

#include "codegen/base/error.h"

namespace nlo::codegen {
namespace {

template <class Scalar>
using BitsOf = std::conditional_t<sizeof(Scalar) == 4, std::uint32_t, std::uint64_t>;

/// A floating literal by the grammar of C++: digits with a point or an exponent, and f for a float.
template <class Scalar>
bool is_literal_of(const std::string& text, Scalar value) {
  std::string digits = text;
  if (sizeof(Scalar) == 4) {
    if (digits.empty() || digits.back() != 'f') return false;
    digits.pop_back();
  }
  if (digits.find_first_not_of("0123456789.e+-") != std::string::npos) return false;
  if (digits.find_first_of(".e") == std::string::npos) return false;
  Scalar read{};
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), read);
  return error == std::errc() && end == digits.data() + digits.size() &&
         std::bit_cast<BitsOf<Scalar>>(read) == std::bit_cast<BitsOf<Scalar>>(value);
}

template <class Scalar>
void expect_random_bits_survive() {
  constexpr int kPatterns = 1'000'000;
  std::mt19937_64 random(20260101);
  for (int i = 0; i < kPatterns; ++i) {
    const auto value = std::bit_cast<Scalar>(static_cast<BitsOf<Scalar>>(random()));
    if (!std::isfinite(value)) continue;
    ASSERT_TRUE(is_literal_of(literal(value), value)) << literal(value);
  }
}

template <class Scalar>
void expect_edges_survive() {
  using Limits = std::numeric_limits<Scalar>;
  for (const Scalar edge :
       {Scalar(0), Limits::denorm_min(), Limits::min(), Limits::max(), Limits::epsilon(),
        std::nextafter(Limits::min(), Scalar(0)), Scalar(1), Scalar(0.1), Scalar(1e5), Scalar(16777216)})
    for (const Scalar value : {edge, -edge}) EXPECT_TRUE(is_literal_of(literal(value), value)) << literal(value);
}

TEST(Literal, ReadsBackToTheSameBitsOverRandomFloats) {
  expect_random_bits_survive<float>();
}
TEST(Literal, ReadsBackToTheSameBitsOverRandomDoubles) {
  expect_random_bits_survive<double>();
}
TEST(Literal, ReadsBackToTheSameBitsAtTheEdges) {
  expect_edges_survive<float>();
  expect_edges_survive<double>();
}

TEST(Literal, IsTheShortest) {
  EXPECT_EQ(literal(1.5f), "1.5f");
  EXPECT_EQ(literal(-0.0f), "-0.0f");
  EXPECT_EQ(literal(1e-7f), "1e-07f");
  EXPECT_EQ(literal(3.0f), "3.0f");
  EXPECT_EQ(literal(0.1), "0.1");
  EXPECT_EQ(literal(100000.0), "1e+05");
}

TEST(Literal, RefusesWhatIsNotFinite) {
  EXPECT_THROW(literal(std::numeric_limits<float>::quiet_NaN()), Error);
  EXPECT_THROW(literal(-std::numeric_limits<double>::infinity()), Error);
}

TEST(Literal, CheckSeesALostBitAndAMissingPoint) {  // the control of this file's own detector
  EXPECT_FALSE(is_literal_of("0.1f", std::nextafter(0.1f, 1.0f)));
  EXPECT_FALSE(is_literal_of("3f", 3.0f));
  EXPECT_FALSE(is_literal_of("3.0", 3.0f));
  EXPECT_FALSE(is_literal_of("0.0", -0.0));
}

}  // namespace
}  // namespace nlo::codegen
