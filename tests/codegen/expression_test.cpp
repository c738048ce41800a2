// SPDX-License-Identifier: MIT
// Computed outputs: an expression has the same value in all code that evaluates it.
#include "codegen/model/expression.h"

#include <gtest/gtest.h>

#include <bit>
#include <charconv>
#include <clocale>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <string>

#include "codegen/base/error.h"
#include "codegen/base/number.h"
#include "codegen/model/computed_outputs.h"
#include "codegen/model/shared_expressions.h"
#include "tests/support/thrown_message.h"

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
  return "accepted";
}

TEST(Expression, EvaluatesByTheRulesOfArithmetic) {
  EXPECT_EQ(value("a*b", 3.0, 4.0, 0.0), 12.0);
  EXPECT_EQ(value("a - b - c", 1.0, 2.0, 4.0), -5.0);  // from left to right
  EXPECT_EQ(value("a - (b - c)", 1.0, 2.0, 4.0), 3.0);
  EXPECT_EQ(value("a + b * c", 1.0, 2.0, 4.0), 9.0);  // products first
  EXPECT_EQ(value("(a + b) * c", 1.0, 2.0, 4.0), 12.0);
  EXPECT_EQ(value("-a^2", 3.0, 0.0, 0.0), -9.0);  // powers before the sign
  EXPECT_EQ(value("(a + b)^3", 1.0, 1.0, 0.0), 8.0);
  EXPECT_EQ(value("a / 4 * 1e2", 3.0, 0.0, 0.0), 75.0);
  EXPECT_TRUE(std::isnan(value("a * b", std::nan(""), 0.0, 0.0)));
}

TEST(Expression, IsWrittenInTheOrderOfEvaluation) {
  EXPECT_EQ(written("a * b * c"), "r[0] * r[1] * r[2]");
  EXPECT_EQ(written("a * (b * c)"), "r[0] * (r[1] * r[2])");
  EXPECT_EQ(written("a - (b - c)"), "r[0] - (r[1] - r[2])");
  EXPECT_EQ(written("1.5 * a * b - c^2"), "rounded(1.5 * r[0] * r[1]) - rounded(r[2] * r[2])");
  EXPECT_EQ(written("(a + b) * c"), "(r[0] + r[1]) * r[2]");
}

TEST(Expression, ErrorsNameThePlace) {
  EXPECT_EQ(
      refusal("a * d"),
      "expression \"a * d\" reads \"d\": expected a measured output that does not wrap, or an input; there is a, b, c");
  EXPECT_NE(refusal("a b").find("at \"b\": expected an operator"), std::string::npos);
  EXPECT_NE(refusal("a / b").find("at \"b\": expected a number other than 0"), std::string::npos);
  EXPECT_NE(refusal("a / 0").find("a number other than 0"), std::string::npos);
  EXPECT_NE(refusal("(a").find("at its end: expected \")\""), std::string::npos);
  EXPECT_NE(refusal("a^9").find("at \"9\": expected a whole power from 1 to 4"), std::string::npos);
  EXPECT_NE(refusal("2 * 3").find("has no name in it"), std::string::npos);
  EXPECT_NE(refusal("").find("expected a number"), std::string::npos);
  EXPECT_NE(refusal("a * 1e300").find("expected a number"), std::string::npos);
  EXPECT_NE(refusal("((a + b)^4 + 1)^4").find("too long"), std::string::npos);
  EXPECT_NE(refusal((std::string(500, '(') + "a").c_str()).find("fewer parentheses"), std::string::npos);
}

TEST(Expression, ValuesStayWithinTheInterval) {
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
  // A point stays a point, except for rounding outwards.
  const Interval point = expression.evaluate<Interval>([&](int) { return Interval(1.0); });
  EXPECT_LE(point.low, 0.0);
  EXPECT_GE(point.high, 0.0);
  EXPECT_LT(point.high - point.low, 1e-14);
  const Interval sum = Interval(0.1) + Interval(0.2);
  EXPECT_LT(sum.low, 0.1 + 0.2);
  EXPECT_GT(sum.high, 0.1 + 0.2);
}

constexpr auto kFunctions = Expression::Language::kFunctions;
const std::vector<std::string> kEquations = {
    "sin(a) / (2 + cos(b)^2)",     "tanh(a / 0.3) - exp(-b^2) * c",
    "sqrt(1 + a^2) + ln(2 + b^2)", "atan(3 * a) * abs(b)",
    "sign(a) * tan(c / 3)",        "-a^2 / 2 / c + pi * b",
    "max(a, 0) * min(b, c, 0.5)",  "sqrt(max(a * b, 0)) - max(c, 1) * min(c, -2)"};

TEST(Expression, InEquationsMayHaveDivisionsAndFunctions) {
  const double at[] = {0.7, -1.3, 0.9};
  const auto number = [&](const std::string& text) {
    return Expression(text, kNames, kFunctions).evaluate<double>([&](int j) { return at[j]; });
  };
  EXPECT_EQ(number("sin(a) / (2 + cos(b)^2)"), std::sin(0.7) / (2.0 + std::cos(-1.3) * std::cos(-1.3)));
  EXPECT_EQ(number("a / b / c"), 0.7 / -1.3 / 0.9);
  EXPECT_EQ(number("a / (b / c)"), 0.7 / (-1.3 / 0.9));
  EXPECT_NEAR(number("-tanh(a)^2"), -std::tanh(0.7) * std::tanh(0.7), 1e-15);
  EXPECT_NEAR(number("exp(-abs(b)) + ln(a) - sqrt(c) * sign(b)"), std::exp(-1.3) + std::log(0.7) + std::sqrt(0.9),
              1e-15);
  EXPECT_NEAR(number("tan(a) - atan(c)"), std::tan(0.7) - std::atan(0.9), 1e-15);
  EXPECT_EQ(number("2 * pi"), 2.0 * std::numbers::pi);
  EXPECT_EQ(number("a / 4"), 0.7 / 4.0) << "division by a number: multiplication by its reciprocal";
  EXPECT_NE(refusal("sin(a)").find("reads \"sin\""), std::string::npos)
      << "control: computed outputs have no functions";
  const auto refused = [](const char* text) { return thrown_message([&] { Expression(text, kNames, kFunctions); }); };
  EXPECT_NE(refused("a / 0").find("a number other than 0"), std::string::npos);
  EXPECT_NE(refused("mod(a, b)").find("a function (sin, cos, tanh, exp, ln, sqrt, atan, abs, sign, tan, min, max)"),
            std::string::npos);
  EXPECT_NE(refused("max(a, b").find("expected \",\" or \")\""), std::string::npos);
  EXPECT_NE(refused("sin a").find("expected \"(\""), std::string::npos);
  EXPECT_NE(refused("sin(a").find("expected \")\""), std::string::npos);
}

TEST(Expression, InEquationsMayHaveMinimumAndMaximum) {
  const auto of = [](const char* text) { return Expression(text, kNames, kFunctions); };
  const auto number = [&](const char* text, double a, double b) {
    return of(text).evaluate<double>([&](int j) { return j == 0 ? a : b; });
  };
  EXPECT_EQ(number("max(a, b)", -0.1, 0.3), 0.3);
  EXPECT_EQ(number("min(a, b)", -0.1, 0.3), -0.1);
  EXPECT_EQ(number("max(a, b, 0.5, -2)", -0.1, 0.3), 0.5);
  EXPECT_EQ(number("2 * max(a)", -0.1, 0.3), -0.2) << "the maximum of one value is that value, as in muParser";
  const double none = std::nan("");
  for (const char* text : {"max(a, b)", "min(a, b)"}) {
    EXPECT_TRUE(std::isnan(number(text, none, 1.0))) << "a corrupted value must not be hidden";
    EXPECT_TRUE(std::isnan(number(text, 1.0, none)));
  }
  const Interval range = of("max(a, 0.25)").evaluate<Interval>([](int) { return Interval(-1.0, 2.0); });
  EXPECT_EQ(range.low, 0.25) << "so its root and its reciprocal are bounded";
  EXPECT_EQ(range.high, 2.0);
  EXPECT_EQ(of("max(a * b, c) - min(a, 2)")
                .text([](int j) { return "r[" + std::to_string(j) + "]"; }, [](double n) { return literal(n); },
                      [](const std::string& product) { return "rounded(" + product + ")"; }),
            "maximum(rounded(r[0] * r[1]), r[2]) - minimum(r[0], 2.0)");
}

TEST(Expression, EvaluatesSharedPartsOnce) {
  std::vector<Expression> all;
  for (const char* text : {"sin(a) * cos(b) - (a + b)^2", "sin(a) / (a + b) - b^2", "c"})
    all.emplace_back(text, kNames, kFunctions);
  const SharedExpressions shared(all, 3);
  ASSERT_EQ(shared.parts.size(), 2) << "sin(a) and a + b; the square of a name is not shared";
  const double at[] = {0.7, -1.3, 0.9};
  const auto reading = [&](int j) { return at[j]; };
  double values[3];
  shared.evaluate(reading, values);
  for (std::size_t i = 0; i < all.size(); ++i)
    EXPECT_EQ(values[i], all[i].evaluate<double>(reading)) << "the same bits";
}

TEST(Expression, ValuesOfEquationsStayWithinTheInterval) {
  std::mt19937 random(7);
  for (const std::string& text : kEquations) {
    const SharedExpressions shared({Expression(text, kNames, kFunctions)}, 3);
    for (int trial = 0; trial < 200; ++trial) {
      std::uniform_real_distribution<double> middle(-3.0, 3.0), half(0.0, 1.5), part(-1.0, 1.0);
      double centre[3], size[3];
      for (int j = 0; j < 3; ++j) {
        centre[j] = middle(random);
        size[j] = half(random);
      }
      Interval range;
      shared.evaluate([&](int j) { return Interval(centre[j] - size[j], centre[j] + size[j]); }, &range);
      for (int sample = 0; sample < 50; ++sample) {
        double at[3];
        for (int j = 0; j < 3; ++j) at[j] = centre[j] + size[j] * part(random);
        double value = 0.0;
        shared.evaluate([&](int j) { return at[j]; }, &value);
        constexpr double kRounding = 1e-12;  // ends are rounded to nearest
        EXPECT_GE(value, range.low - kRounding * (1.0 + std::abs(value))) << text;
        EXPECT_LE(value, range.high + kRounding * (1.0 + std::abs(value))) << text;
      }
    }
  }
  EXPECT_FALSE((Interval(1.0) / Interval(-0.1, 0.2)).bounded()) << "a possible division by 0 has no bound";
  EXPECT_FALSE(value_of(Function::kRoot, Interval(-0.1, 1.0)).bounded());
  EXPECT_FALSE(value_of(Function::kSine, Interval(0.0, 1e4)).bounded()) << "a float this large has no precise angle";
  EXPECT_EQ(square(Interval(-1.0, 0.5)).low, 0.0) << "tighter than the product of intervals";
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
  // Control: compares the declared parity with values at arguments of both signs.
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0.3, 1.0);
  for (const std::string& text : kEquations) {
    const Expression expression(text, kNames, kFunctions);
    const double at[] = {uniform(random), uniform(random), uniform(random)};
    const auto valued = [&](double sign) {
      return expression.evaluate<double>([&](int j) { return j < 2 ? sign * at[j] : at[j]; });
    };
    const Parity found = expression.parity({Parity::kOdd, Parity::kOdd, Parity::kEven});
    EXPECT_EQ(found == Parity::kEven, std::abs(valued(1.0) - valued(-1.0)) < 1e-12) << text;
    EXPECT_EQ(found == Parity::kOdd, std::abs(valued(1.0) + valued(-1.0)) < 1e-12) << text;
  }
}

TEST(ComputedOutputs, OverwriteTheRowsAfterTheMeasuredOnes) {
  const ComputedOutputs computed({{"a", "", 0.0}, {"b", "", 0.0}, {"p", "", 0.0, "a * u - b"}}, {{"u", "", 0.0}});
  Eigen::MatrixXd outputs(3, 2);
  outputs << 1.0, 2.0, 3.0, 4.0, 99.0, 99.0;
  computed.fill(outputs, Eigen::RowVector2d(5.0, 6.0));
  EXPECT_EQ(outputs(2, 0), 2.0);
  EXPECT_EQ(outputs(2, 1), 8.0);
}

template <class Scalar>
using BitsOf = std::conditional_t<sizeof(Scalar) == 4, std::uint32_t, std::uint64_t>;

/// Returns true if a text is a C++ floating literal: digits with a point or an exponent, and f for a float.
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

TEST(Literal, IsTheShortestThatReadsBack) {
  EXPECT_EQ(literal(1.5f), "1.5f");
  EXPECT_EQ(literal(-0.0f), "-0.0f");
  EXPECT_EQ(literal(1e-7f), "1e-07f");
  EXPECT_EQ(literal(3.0f), "3.0f");
  EXPECT_EQ(literal(0.1), "0.1");
  EXPECT_EQ(literal(100000.0), "1e+05");
}

TEST(Literal, RefusesNumbersThatAreNotFinite) {
  EXPECT_THROW(literal(std::numeric_limits<float>::quiet_NaN()), Error);
  EXPECT_THROW(literal(-std::numeric_limits<double>::infinity()), Error);
}

TEST(Literal, CheckDetectsALostBitAndAMissingPoint) {  // the control of this file's own detector
  EXPECT_FALSE(is_literal_of("0.1f", std::nextafter(0.1f, 1.0f)));
  EXPECT_FALSE(is_literal_of("3f", 3.0f));
  EXPECT_FALSE(is_literal_of("3.0", 3.0f));
  EXPECT_FALSE(is_literal_of("0.0", -0.0));
}

}  // namespace
}  // namespace nlo::codegen
