// SPDX-License-Identifier: MIT
// Functions as polynomials with a remainder: the error is within the remainder everywhere in the box, the remainder has
// its order, and for polynomials only rounding remains.
#include "trainer/prove/taylor_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>

namespace nlo::trainer {
namespace {

using codegen::Function;

struct OfOneVariable {
  std::string name;
  std::function<TaylorModel(const TaylorModel&)> model;
  std::function<double(double)> value;
  double centre;
};

TaylorModel call(Function function, const TaylorModel& x) {
  return value_of(function, x);
}

const OfOneVariable kFunctions[] = {
    {"sin", [](const TaylorModel& x) { return call(Function::kSine, x); }, [](double x) { return std::sin(x); }, 0.7},
    {"cos", [](const TaylorModel& x) { return call(Function::kCosine, x); }, [](double x) { return std::cos(x); }, 2.5},
    {"tanh", [](const TaylorModel& x) { return call(Function::kTanh, x); }, [](double x) { return std::tanh(x); }, 0.4},
    {"exp", [](const TaylorModel& x) { return call(Function::kExponential, x); }, [](double x) { return std::exp(x); },
     -0.3},
    {"ln", [](const TaylorModel& x) { return call(Function::kLogarithm, x); }, [](double x) { return std::log(x); },
     1.8},
    {"atan", [](const TaylorModel& x) { return call(Function::kArcTangent, x); }, [](double x) { return std::atan(x); },
     0.6},
    {"quotient", [](const TaylorModel& x) { return TaylorModel(1.0) / (TaylorModel(2.0) + x * x); },
     [](double x) { return 1.0 / (2.0 + x * x); }, 0.5}};

/// The bound of the difference between the model and the true f. On a box of width zero, f would be constant, so the
/// test compares over small boxes around points.
TEST(TaylorModel, EnclosesEveryPointOfTheBox) {
  std::mt19937 engine(1);
  std::uniform_real_distribution<double> within(-1.0, 1.0);
  for (const OfOneVariable& f : kFunctions) {
    const double radius = 0.3;
    const TaylorModel x = TaylorModel::variable(0, f.centre, radius);
    for (int i = 0; i < 200; ++i) {
      const double at = f.centre + radius * within(engine);
      // f - f(at) has a root in the box, so its range contains 0 and |f - f(at)| is at least |f(other) - f(at)|.
      const double other = f.centre + radius * within(engine);
      const double most = (f.model(x) - TaylorModel(f.value(at))).most();
      EXPECT_GE(most, std::abs(f.value(other) - f.value(at)) * (1.0 - 1e-12)) << f.name;
    }
  }
}

TEST(TaylorModel, DifferenceOfEqualFunctionsIsOnlyTheRemainder) {
  // sin^2 + cos^2 - 1: interval arithmetic would give 1; here the remainder is of the order of radius^7.
  double before = 0.0;
  for (const double radius : {0.4, 0.2, 0.1}) {
    const TaylorModel x = TaylorModel::variable(1, 0.8, radius);
    const TaylorModel s = call(Function::kSine, x), c = call(Function::kCosine, x);
    const double left = (s * s + c * c - TaylorModel(1.0)).most();
    if (before > 0.0) {
      EXPECT_NEAR(std::log2(before / left), 7.0, 0.7) << "order of the remainder";  // its factor varies
    }
    before = left;
  }
  EXPECT_LT(before, 1e-6);
}

TEST(TaylorModel, PolynomialsOfItsDegreeAreExactExceptForRounding) {
  const TaylorModel x = TaylorModel::variable(0, 1.5, 0.5), y = TaylorModel::variable(2, -2.0, 0.25);
  const TaylorModel left = (x + y) * (x + y) * (x - y) - (x * x * x + x * x * y - x * y * y - y * y * y);
  EXPECT_LT(left.most(), 1e-11);  // gamma of about 170 operations on numbers up to 43
  EXPECT_GT(left.most(), 0.0) << "it includes rounding";
}

TEST(TaylorModel, HasNoBoundOutsideTheDomainOfAFunction) {
  const TaylorModel x = TaylorModel::variable(0, 0.1, 0.5);
  EXPECT_TRUE(std::isinf((TaylorModel(1.0) / x).most()));
  EXPECT_TRUE(std::isinf(call(Function::kLogarithm, x).most()));
  EXPECT_TRUE(std::isinf(call(Function::kRoot, x).most()));
}

TEST(TaylorModel, RemainderContainsHigherDegrees) {
  TaylorModel model(0.0);
  model.add({4, 3, 0}, 0.25);
  EXPECT_GE(model.most(), 0.25);
  EXPECT_LT(model.most(), 0.2501);
}

}  // namespace
}  // namespace nlo::trainer
