// SPDX-License-Identifier: MIT
// The latent recurrence: its coefficients compared with long double, closed forms, matrix exponentials and explicit
// Runge-Kutta stages, and its orders of convergence.
#include <nlo/exponential_rk.h>
#include <nlo/latent.h>

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "tests/runtime/linear_oracles.h"
#include "tests/runtime/testing.h"

namespace nlo {
namespace {

using Long = std::complex<long double>;
using Mode = std::complex<double>;

/// exp(w) - 1, phi_1, phi_2 in long double: series for small w, definitions elsewhere.
struct Exact {
  Long exp_minus_1, phi1, phi2;
  explicit Exact(Long w) {
    if (std::abs(w) < 1.0L) {
      Long term = 0.5L;
      for (int k = 3; k < 40; ++k) phi2 += term, term *= w / static_cast<long double>(k);
      phi1 = 1.0L + w * phi2;
      exp_minus_1 = w * phi1;
    } else {
      exp_minus_1 = std::exp(w) - 1.0L;
      phi1 = exp_minus_1 / w;
      phi2 = (phi1 - 1.0L) / w;
    }
  }
};

template <class T>
struct PhiFunctions : ::testing::Test {};
using Scalars = ::testing::Types<float, double>;
TYPED_TEST_SUITE(PhiFunctions, Scalars);

template <class T>
long double distance(Complex<T> c, Long reference) {
  return std::abs(Long(static_cast<long double>(c.re), static_cast<long double>(c.im)) - reference);
}

TYPED_TEST(PhiFunctions, AreWithinThreeRoundingUnitsOnTheNegativeAxis) {
  using T = TypeParam;
  constexpr long double kTolerance = 3 * static_cast<long double>(std::numeric_limits<T>::epsilon());
  for (double exponent = -12.0; exponent <= 4.0; exponent += 0.003) {
    const T w = static_cast<T>(-std::pow(10.0, exponent));
    const auto phi = Phi<T>::at({w, T(0)});
    const Exact exact(Long(static_cast<long double>(w), 0.0L));
    ASSERT_LE(distance(phi.exp_minus_1, exact.exp_minus_1), kTolerance * std::abs(exact.exp_minus_1)) << w;
    ASSERT_LE(distance(phi.phi1, exact.phi1), kTolerance * std::abs(exact.phi1)) << w;
    ASSERT_LE(distance(phi.phi2, exact.phi2), kTolerance * std::abs(exact.phi2)) << w;
    ASSERT_EQ(phi.exp_minus_1.im, T(0));
  }
}

TYPED_TEST(PhiFunctions, HaveTheAccuracyOfTheirConditionInTheLeftHalfPlane) {
  using T = TypeParam;
  const long double eps = static_cast<long double>(std::numeric_limits<T>::epsilon());
  for (double exponent = -12.0; exponent <= 4.0; exponent += 0.05) {
    for (int a = -64; a <= 64; ++a) {
      const double angle = testing::kPi * (1.0 + 0.5 * a / 64.0);
      const Complex<T> w{std::min(T(0), static_cast<T>(std::pow(10.0, exponent) * std::cos(angle))),
                         static_cast<T>(std::pow(10.0, exponent) * std::sin(angle))};
      const Long exact_w(static_cast<long double>(w.re), static_cast<long double>(w.im));
      const auto phi = Phi<T>::at(w);
      const Exact exact(exact_w);
      // exp(w) - 1 and phi_1 have zeros at 2 pi i k; there the error is relative to the size of the function nearby.
      const long double size = std::abs(exact_w), tolerance = 2 * eps * (1 + size);
      const long double around = size < 1 ? 0 : 1;
      ASSERT_LE(distance(phi.exp_minus_1, exact.exp_minus_1), tolerance * std::max(std::abs(exact.exp_minus_1), around))
          << w.re << ' ' << w.im;
      ASSERT_LE(distance(phi.phi1, exact.phi1), tolerance * std::max(std::abs(exact.phi1), around / (size + 1)))
          << w.re << ' ' << w.im;
      ASSERT_LE(distance(phi.phi2, exact.phi2), tolerance * std::abs(exact.phi2)) << w.re << ' ' << w.im;
    }
  }
}

TYPED_TEST(PhiFunctions, TerminateForAnyArgument) {
  using T = TypeParam;
  using Limits = std::numeric_limits<T>;
  for (const T re : {-Limits::infinity(), Limits::infinity(), Limits::quiet_NaN(), Limits::lowest(), Limits::max()}) {
    for (const T im : {T(0), Limits::max(), -Limits::infinity(), Limits::quiet_NaN()}) {
      EXPECT_LE(Halved<T>({re, im}).doublings, Limits::max_exponent + 2) << re << ' ' << im;
      (void)Phi<T>::at({re, im});
      (void)ForcedPhi<T>::at({re, im});
    }
  }
  EXPECT_EQ(Halved<T>({T(-1e6), T(1e6)}).doublings, 22) << "the fastest mode over the longest gap";
  EXPECT_NEAR((Phi<T>::at({Limits::lowest(), T(0)}).exp_minus_1.re), T(-1), Limits::epsilon());
  for (const T all : {T(65), Limits::max(), Limits::infinity(), Limits::quiet_NaN()})
    EXPECT_EQ(decay_minus_1(all), T(-1)) << all;
  EXPECT_EQ(decay_minus_1(T(1)), (Phi<T>::at({T(-1), T(0)}).exp_minus_1.re));
}

TYPED_TEST(PhiFunctions, EqualTheirLimitsAtZeroAndAtMinusInfinity) {
  using T = TypeParam;
  const auto zero = Phi<T>::at({T(0), T(0)});
  EXPECT_EQ(zero.exp_minus_1.re, T(0));
  EXPECT_EQ(zero.phi1.re, T(1));
  EXPECT_EQ(zero.phi2.re, T(0.5));
  const auto far = Phi<T>::at({T(-1e30), T(0)});
  EXPECT_EQ(far.exp_minus_1.re, T(-1));
  EXPECT_NEAR(far.phi1.re, T(0), T(1.1e-30));
  EXPECT_NEAR(far.phi2.re, T(0), T(1.1e-30));
}

// A pair and two real modes, two outputs.
constexpr int kNz = 4, kNy = 2, kPairs = 1;
constexpr double kEigenvalues[kNz] = {-1.5, 4.0, -0.01, -30.0};
constexpr double kInjection[kNz][kNy] = {{1.0, -0.5}, {0.25, 2.0}, {1.0, 0.0}, {3.0, -1.0}};
constexpr double kRounding = 1e-14;  // several tens of rounding units of values near 1
using Latent = Eigen::Matrix<double, kNz, 1>;
using Output = Eigen::Matrix<double, kNy, 1>;

struct Matrices {
  Eigen::Matrix<double, kNz, kNz> d = Eigen::Matrix<double, kNz, kNz>::Zero();
  Eigen::Matrix<double, kNz, kNy> f;
  Matrices() {
    d << kEigenvalues[0], -kEigenvalues[1], 0, 0, kEigenvalues[1], kEigenvalues[0], 0, 0, 0, 0, kEigenvalues[2], 0, 0,
        0, 0, kEigenvalues[3];
    for (int r = 0; r < kNz; ++r) {
      for (int j = 0; j < kNy; ++j) f(r, j) = kInjection[r][j];
    }
  }
};

Latent stepped(Hold hold, double h, const Latent& z0, const Output& y0, const Output& y1) {
  const auto step = discretise<kPairs>(hold, kEigenvalues, kInjection, h);
  double z[kNz], from[kNy], to[kNy];
  for (int r = 0; r < kNz; ++r) z[r] = z0(r);
  for (int j = 0; j < kNy; ++j) from[j] = y0(j), to[j] = y1(j);
  advance<kPairs>(step, z, from, to);
  return Eigen::Map<Latent>(z);
}

/// Exponential of the system [z; y; slope of y].
Latent by_matrix_exponential(double h, const Latent& z0, const Output& y0, const Output& slope) {
  const Matrices m;
  Eigen::Matrix<double, kNz + 2 * kNy, kNz + 2 * kNy> all;
  all.setZero();
  all.topLeftCorner<kNz, kNz>() = m.d;
  all.block<kNz, kNy>(0, kNz) = m.f;
  all.block<kNy, kNy>(kNz, kNz + kNy).setIdentity();
  Eigen::Matrix<double, kNz + 2 * kNy, 1> start;
  start << z0, y0, slope;
  const Eigen::Matrix<double, kNz + 2 * kNy, kNz + 2 * kNy> flow = testing::exponential(all * h);
  return (flow * start).head<kNz>();
}

const Latent kZ0(0.5, -1.0, 2.0, 0.25);
const Output kY0(1.0, -0.75), kY1(0.5, 2.0);

TEST(LatentStep, AgreesWithTheMatrixExponential) {
  for (const double h : {1e-4, 0.004, 0.02, 0.3, 2.0}) {
    const Latent held = by_matrix_exponential(h, kZ0, kY0, Output::Zero());
    const Latent ramp = by_matrix_exponential(h, kZ0, kY0, (kY1 - kY0) / h);
    const double tolerance = 20 * kRounding;  // the exponential also squares
    EXPECT_LT((stepped(Hold::kZeroOrder, h, kZ0, kY0, kY1) - held).cwiseAbs().maxCoeff(), tolerance) << h;
    EXPECT_LT((stepped(Hold::kFirstOrder, h, kZ0, kY0, kY1) - ramp).cwiseAbs().maxCoeff(), tolerance) << h;
  }
}

/// Solution of z' = lambda z + u0 + slope t.
Mode on_ramp(Mode lambda, Mode z0, Mode u0, Mode slope, double t) {
  const Long l = lambda, b = -Long(slope) / l, a = (b - Long(u0)) / l;
  return Mode((Long(z0) - a) * std::exp(l * static_cast<long double>(t)) + a + b * static_cast<long double>(t));
}

TEST(LatentStep, IsExactForConstantsAndRamps) {
  const auto input = [](const Output& y, int r) { return kInjection[r][0] * y(0) + kInjection[r][1] * y(1); };
  for (const double h : {0.004, 0.02, 1.0, 10.0}) {
    for (const Hold hold : {Hold::kZeroOrder, Hold::kFirstOrder}) {
      const Output end = hold == Hold::kZeroOrder ? kY0 : kY1;
      const Latent z = stepped(hold, h, kZ0, kY0, kY1);
      const Output slope = (end - kY0) / h;
      const Mode pair = on_ramp({kEigenvalues[0], kEigenvalues[1]}, {kZ0(0), kZ0(1)}, {input(kY0, 0), input(kY0, 1)},
                                {input(slope, 0), input(slope, 1)}, h);
      // The closed form of the slow mode cancels: slope / lambda^2 ~ 3e6 in long double.
      const double tolerance = 20 * kRounding * (1 + h);
      EXPECT_NEAR(z(0), pair.real(), tolerance) << h;
      EXPECT_NEAR(z(1), pair.imag(), tolerance) << h;
      for (int r = 2; r < kNz; ++r) {
        EXPECT_NEAR(z(r), on_ramp(kEigenvalues[r], kZ0(r), input(kY0, r), input(slope, r), h).real(), tolerance) << h;
      }
    }
  }
}

TEST(LatentStep, ByRk4EqualsItsFourStages) {
  const Matrices m;
  for (const double h : {0.001, 0.02, 0.05}) {
    const Output middle = 0.5 * (kY0 + kY1);
    const auto slope = [&](const Latent& z, const Output& y) -> Latent { return m.d * z + m.f * y; };
    const Latent k1 = slope(kZ0, kY0);
    const Latent k2 = slope(kZ0 + h / 2 * k1, middle);
    const Latent k3 = slope(kZ0 + h / 2 * k2, middle);
    const Latent k4 = slope(kZ0 + h * k3, kY1);
    const Latent by_hand = kZ0 + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    EXPECT_LT((stepped(Hold::kRk4, h, kZ0, kY0, kY1) - by_hand).cwiseAbs().maxCoeff(), kRounding) << h;
  }
}

/// z(2) of z' = lambda z + sin(t), z(0) = 1, in `steps` steps.
Mode on_sine(Hold hold, Mode lambda, int steps) {
  const double h = 2.0 / steps;
  const auto step = discretise(hold, Complex<double>{lambda.real(), lambda.imag()}, h);
  const auto mode = [](Complex<double> c) { return Mode(c.re, c.im); };
  Mode z = 1.0;
  for (int k = 0; k < steps; ++k) {
    z += mode(step.a_minus_1) * z + mode(step.b0) * std::sin(k * h) + mode(step.b1) * std::sin((k + 1) * h);
  }
  return z;
}

TEST(Hold, HasItsOrderOfConvergence) {
  constexpr double kSlack = 0.1;  // share of the next order at these steps
  for (const Mode lambda : {Mode(-1.5, 2.0), Mode(-3.0, 0.0)}) {
    const auto particular = [&](double t) { return -(lambda * std::sin(t) + std::cos(t)) / (lambda * lambda + 1.0); };
    const Mode exact = (1.0 - particular(0.0)) * std::exp(2.0 * lambda) + particular(2.0);
    const auto order = [&](Hold hold) {
      return std::log2(std::abs(on_sine(hold, lambda, 40) - exact) / std::abs(on_sine(hold, lambda, 80) - exact));
    };
    EXPECT_NEAR(order(Hold::kZeroOrder), 1.0, kSlack);
    EXPECT_NEAR(order(Hold::kFirstOrder), 2.0, kSlack);
    // RK4 on the ramp approaches the exact ramp; compared with the sine, both have the order of the ramp.
    const auto to_ramp = [&](int n) {
      return std::abs(on_sine(Hold::kRk4, lambda, n) - on_sine(Hold::kFirstOrder, lambda, n));
    };
    EXPECT_GT(std::log2(to_ramp(40) / to_ramp(80)), 4.0 - kSlack);
    EXPECT_LT(std::log2(to_ramp(40) / to_ramp(80)), 4.0 + 3 * kSlack);
  }
}

}  // namespace
}  // namespace nlo
