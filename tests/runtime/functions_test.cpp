// SPDX-License-Identifier: MIT
// Functions of known equations: their accuracy compared with libm, and their result outside of their domain.
#include <nlo/functions.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace nlo {
namespace {

/// Largest error over `from` to `to`, relative to the larger of `least` and the value, in rounding units of T.
template <class T, class Function, class Truth>
double worst(const Function& function, const Truth& truth, double from, double to, double least = 1.0) {
  constexpr int kPoints = 200'000;
  double largest = 0.0;
  for (int i = 0; i <= kPoints; ++i) {
    const T x = static_cast<T>(from + (to - from) * i / kPoints);
    const long double value = truth(static_cast<long double>(x));
    const double error = static_cast<double>(std::abs(static_cast<long double>(function(x)) - value)) /
                         std::fmax(least, static_cast<double>(std::abs(value)));
    if (!(error <= largest)) largest = error;
  }
  return largest / static_cast<double>(std::numeric_limits<T>::epsilon());
}

template <class T>
class Functions : public ::testing::Test {};
using Scalars = ::testing::Types<float, double>;
TYPED_TEST_SUITE(Functions, Scalars);

// The tolerances are those in the headers' comments; a rounding unit is half of epsilon.
TYPED_TEST(Functions, AreWithinAFewRoundingUnitsOfLibm) {
  using T = TypeParam;
  using L = long double;
  for (const double range : {0.8, 8.0, 8191.9}) {
    EXPECT_LT(worst<T>([](T x) { return sine(x); }, [](L x) { return std::sin(x); }, -range, range), 1.0);
    EXPECT_LT(worst<T>([](T x) { return cosine(x); }, [](L x) { return std::cos(x); }, -range, range), 1.0);
    EXPECT_LT(worst<T>([](T x) { return arc_tangent(x); }, [](L x) { return std::atan(x); }, -range, range), 1.5);
  }
  EXPECT_LT(worst<T>([](T x) { return exponential(x); }, [](L x) { return std::exp(x); }, -79.9, 79.9, 0.0), 1.5);
  for (const double range : {1e-3, 4.0, 1e30}) {
    EXPECT_LT(worst<T>([](T x) { return square_root(x); }, [](L x) { return std::sqrt(x); }, 1e-9 * range, range, 0.0),
              1.0);
    EXPECT_LT(worst<T>([](T x) { return logarithm(x); }, [](L x) { return std::log(x); }, 1e-9 * range, range), 2.0);
  }
  EXPECT_LT(worst<T>([](T x) { return hyperbolic_tangent(x); }, [](L x) { return std::tanh(x); }, -10.0, 10.0), 8.0);
  EXPECT_GT(worst<T>([](T x) { return sine(x); }, [](L x) { return std::sin(x * (1.0L + 1e-6L)); }, -8.0, 8.0), 2.0)
      << "control";
}

TYPED_TEST(Functions, AreNanOutsideOfTheirDomain) {
  using T = TypeParam;
  constexpr T kNone = std::numeric_limits<T>::quiet_NaN(), kInfinity = std::numeric_limits<T>::infinity();
  for (const T x : {T(8192), T(-8192), kInfinity, -kInfinity, kNone}) {
    EXPECT_TRUE(std::isnan(sine(x)) && std::isnan(cosine(x)));
  }
  for (const T x : {T(80), kInfinity, kNone}) EXPECT_TRUE(std::isnan(exponential(x)));
  for (const T x : {T(-1), -kInfinity, kInfinity, kNone})
    EXPECT_TRUE(std::isnan(square_root(x)) && std::isnan(logarithm(x)));
  EXPECT_TRUE(std::isnan(logarithm(T(0))) && std::isnan(arc_tangent(kNone)) && std::isnan(sign_of(kNone)));
  EXPECT_EQ(exponential(T(-80)), T(0));
  EXPECT_EQ(square_root(T(0)), T(0));
  EXPECT_EQ(sine(T(0)), T(0));
  EXPECT_EQ(cosine(T(0)), T(1));
  EXPECT_EQ(sign_of(T(-3)), T(-1));
  EXPECT_EQ(sign_of(T(0)), T(0));
  EXPECT_EQ(magnitude(T(-3)), T(3));
  EXPECT_EQ(minimum(T(-3), T(2)), T(-3));
  EXPECT_EQ(maximum(T(-3), T(2)), T(2));
  EXPECT_TRUE(std::isnan(minimum(kNone, T(1))) && std::isnan(minimum(T(1), kNone)));
  EXPECT_TRUE(std::isnan(maximum(kNone, T(1))) && std::isnan(maximum(T(1), kNone)));
  EXPECT_NEAR(static_cast<double>(arc_tangent(-kInfinity)), -1.5707963267948966, 1e-7);
}

}  // namespace
}  // namespace nlo
