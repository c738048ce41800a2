// SPDX-License-Identifier: MIT
// Outputs that are computed: what an expression means, whatever reads it.
#include "codegen/model/expression.h"

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
#include "codegen/base/number.h"
#include "codegen/model/computed_outputs.h"

namespace nlo::codegen {
namespace {

const std::vector<std::string> kNames = {"a", "b", "c"};

double value(const char* text, double a, double b, double c) {
  const double readings[] = {a, b, c};
  return Expression(text, kNames).evaluate<double>([&](int j) { return readings[j]; });
}

std::string written(const char* text) {
  return Expression(text, kNames)
      .text([](int j) { return "r[" + std::to_string(j) + "]"; }, [](double number) { return literal(number); },
            [](const std::string& product) { return "rounded(" + product + ")"; });
}

std::string refusal(const char* text) {
  try {
    Expression(text, kNames);
  } catch (const Error& error) {
    return error.what();
  }
  return "taken";
}

TEST(Expression, MeansWhatItsArithmeticSays) {
  EXPECT_EQ(value("a*b", 3.0, 4.0, 0.0), 12.0);
  EXPECT_EQ(value("a - b - c", 1.0, 2.0, 4.0), -5.0);  // from the left
  EXPECT_EQ(value("a - (b - c)", 1.0, 2.0, 4.0), 3.0);
  EXPECT_EQ(value("a + b * c", 1.0, 2.0, 4.0), 9.0);  // products first
  EXPECT_EQ(value("(a + b) * c", 1.0, 2.0, 4.0), 12.0);
  EXPECT_EQ(value("-a^2", 3.0, 0.0, 0.0), -9.0);  // powers before the sign
  EXPECT_EQ(value("(a + b)^3", 1.0, 1.0, 0.0), 8.0);
  EXPECT_EQ(value("a / 4 * 1e2", 3.0, 0.0, 0.0), 75.0);
  EXPECT_TRUE(std::isnan(value("a * b", std::nan(""), 0.0, 0.0)));
}

TEST(Expression, IsWrittenInTheOrderInWhichItIsEvaluated) {
  EXPECT_EQ(written("a * b * c"), "r[0] * r[1] * r[2]");
  EXPECT_EQ(written("a * (b * c)"), "r[0] * (r[1] * r[2])");
  EXPECT_EQ(written("a - (b - c)"), "r[0] - (r[1] - r[2])");
  EXPECT_EQ(written("1.5 * a * b - c^2"), "rounded(1.5 * r[0] * r[1]) - rounded(r[2] * r[2])");
  EXPECT_EQ(written("(a + b) * c"), "(r[0] + r[1]) * r[2]");
}

TEST(Expression, NamesThePlaceThatItCannotRead) {
  EXPECT_EQ(
      refusal("a * d"),
      "expression \"a * d\" reads \"d\": expected a measured output that does not wrap, or an input; there is a, b, c");
  EXPECT_NE(refusal("a b").find("at \"b\": expected an operator"), std::string::npos);
  EXPECT_NE(refusal("a / b").find("at \"b\": expected a number other than 0"), std::string::npos);
  EXPECT_NE(refusal("a / 0").find("another number than 0"), std::string::npos);
  EXPECT_NE(refusal("(a").find("at its end: expected \")\""), std::string::npos);
  EXPECT_NE(refusal("a^9").find("at \"9\": expected a whole power from 1 to 4"), std::string::npos);
  EXPECT_NE(refusal("2 * 3").find("reads nothing"), std::string::npos);
  EXPECT_NE(refusal("").find("expected a number"), std::string::npos);
  EXPECT_NE(refusal("a * 1e300").find("expected a number"), std::string::npos);
  EXPECT_NE(refusal("((a + b)^4 + 1)^4").find("too long"), std::string::npos);
  EXPECT_NE(refusal((std::string(500, '(') + "a").c_str()).find("fewer parentheses"), std::string::npos);
}

TEST(Expression, KeepsItsValuesWithinItsInterval) {
  const Expression expression("a * b - 2 * c^2 + a", kNames);
  const Interval box[] = {{-1.0, 2.0}, {-3.0, 0.5}, {-1.0, 1.0}};
  const Interval range = expression.evaluate<Interval>([&](int j) { return box[j]; });
  for (const double a : {-1.0, 0.3, 2.0})
    for (const double b : {-3.0, 0.0, 0.5})
      for (const double c : {-1.0, 0.0, 1.0}) {
        const double at = value("a * b - 2 * c^2 + a", a, b, c);
        EXPECT_GE(at, range.low);
        EXPECT_LE(at, range.high);
      }
  EXPECT_EQ(expression.evaluate<Interval>([&](int) { return Interval(1.0); }).high, 0.0);  // a point stays one
}

TEST(Expression, HasTheParityOfItsProducts) {
  const auto parity = [](const char* text) {
    return Expression(text, kNames).parity({Parity::kOdd, Parity::kOdd, Parity::kEven});
  };
  EXPECT_EQ(parity("a * b"), Parity::kEven);
  EXPECT_EQ(parity("a * c"), Parity::kOdd);
  EXPECT_EQ(parity("a * c + b^3"), Parity::kOdd);
  EXPECT_EQ(parity("a + c"), Parity::kNeither);
  EXPECT_EQ(parity("a + 1"), Parity::kNeither);
  EXPECT_EQ(parity("-2 * a * b + 1"), Parity::kEven);
}

TEST(ComputedOutputs, AreRowsBehindTheMeasuredOnesWhateverStoodThere) {
  const ComputedOutputs computed({{"a", "", 0.0}, {"b", "", 0.0}, {"p", "", 0.0, "a * u - b"}}, {{"u", "", 0.0}});
  Eigen::MatrixXd outputs(3, 2);
  outputs << 1.0, 2.0, 3.0, 4.0, 99.0, 99.0;
  computed.fill(outputs, Eigen::RowVector2d(5.0, 6.0));
  EXPECT_EQ(outputs(2, 0), 2.0);
  EXPECT_EQ(outputs(2, 1), 8.0);
}

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
