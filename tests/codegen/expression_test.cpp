// SPDX-License-Identifier: MIT
// Outputs that are computed: what an expression means, whatever reads it.
#include "codegen/model/expression.h"

#include <gtest/gtest.h>

#include <cmath>

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

}  // namespace
}  // namespace nlo::codegen
