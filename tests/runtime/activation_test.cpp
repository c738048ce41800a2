// SPDX-License-Identifier: MIT
// Activations and their slopes, for scalars and packs, compared with closed forms and finite differences in double.
#include <nlo/jvp.h>
#include <nlo/kernels/activation.h>
#include <nlo/kernels/cortex_m_pieces.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace nlo {
namespace {

double silu(double v) {
  return v / (1.0 + std::exp(-v));
}

/// Calls check(v) on a grid over the curved part of all activations, and far outside.
template <class Check>
void over_a_grid(Check check) {
  for (double v = -20.0; v <= 20.0; v += 1.0 / 128) check(v);
  for (const double v : {-1e3, -100.0, -50.0, 50.0, 100.0, 1e3}) check(v);
}

TEST(Silu, HasTheErrorOfItsTanh) {
  over_a_grid([](double v) {
    const double bound = 0.5 * std::fabs(v) * kTanhMaxError;
    EXPECT_NEAR(activate<Activation::kSilu>(v), silu(v), (0.5 * std::fabs(v) + 1.0) * kTanhMaxErrorDouble) << v;
    const double rounding = std::fabs(v) * static_cast<double>(std::numeric_limits<float>::epsilon());
    const float narrow = static_cast<float>(v);
    EXPECT_NEAR(static_cast<double>(activate<Activation::kSilu>(narrow)), silu(v), bound + rounding) << v;
  });
}

// The table of the Cortex-M kernels, in C++: half of the error of the rational function, without a division.
TEST(TanhByPieces, IsWithinItsErrorOddAndAtMostOne) {
  double worst = 0;
  for (std::uint32_t bits = 0; bits < 0x7f800000U; bits += 4999) {
    const auto x = std::bit_cast<float>(bits);
    const float there = kernels::cortex_m::tanh_by_pieces_plain(x);
    ASSERT_EQ(kernels::cortex_m::tanh_by_pieces_plain(-x), -there) << x;
    ASSERT_LE(there, 1.0F) << x;
    worst = std::max(worst, std::abs(static_cast<double>(there) - std::tanh(static_cast<double>(x))));
    if (x < 0x1p-12F) {
      ASSERT_EQ(there, x);
    }
  }
  EXPECT_LE(worst, 2.4e-7);
  EXPECT_GT(worst, 1e-7);
}

TEST(Relu, IsExact) {
  over_a_grid([](double v) {
    const float x = static_cast<float>(v);
    EXPECT_EQ(activate<Activation::kRelu>(x), x > 0.0F ? x : 0.0F);
    EXPECT_EQ(activate<Activation::kRelu>(v), v > 0.0 ? v : 0.0);
  });
  EXPECT_EQ(activate<Activation::kRelu>(std::numeric_limits<float>::quiet_NaN()), 0.0F);
}

/// Compares slopes with central differences of the same function, in double.
template <Activation kKind>
void expect_slopes(double tolerance) {
  constexpr double kStep = 1e-5;
  over_a_grid([&](double v) {
    if (kKind == Activation::kRelu && std::fabs(v) < 2 * kStep) return;
    if (std::fabs(v) > 100.0) return;  // differences of large numbers lose digits
    const double difference = (activate<kKind>(v + kStep) - activate<kKind>(v - kStep)) / (2 * kStep);
    EXPECT_NEAR(activation_slope<kKind>(v, activate<kKind>(v)), difference, tolerance) << v;
  });
}

TEST(ActivationSlope, AgreesWithFiniteDifferences) {
  // Differences in double err by the rounding of their values, 2e-15 / 2e-5, and by the square of their step.
  constexpr double kDifference = 1e-9;
  expect_slopes<Activation::kTanh>(kDifference);
  expect_slopes<Activation::kRelu>(kDifference);
  expect_slopes<Activation::kSilu>(100.0 * kDifference);  // |v| <= 100 times that
}

TEST(ActivationSlope, AgreesWithTheClosedForms) {
  over_a_grid([](double v) {
    const double t = std::tanh(v), s = 1.0 / (1.0 + std::exp(-v));
    EXPECT_NEAR(activation_slope<Activation::kTanh>(v, activate<Activation::kTanh>(v)), 1.0 - t * t, 2 * kTanhMaxError);
    EXPECT_NEAR(activation_slope<Activation::kSilu>(v, activate<Activation::kSilu>(v)), s + v * s * (1.0 - s),
                (1.0 + std::fabs(v)) * kTanhMaxError)
        << v;
  });
}

template <Activation kKind>
void expect_packs_agree() {
  using Pack = simd::Pack<float>;
  constexpr int kLanes = simd::kLanes<float>;
  constexpr double kContraction = 4e-7;  // a scalar may be compiled with other fused multiply-adds than a pack
  float in[kLanes], out[kLanes], slopes[kLanes];
  over_a_grid([&](double v) {
    for (int i = 0; i < kLanes; ++i) in[i] = static_cast<float>(v) + 0.001F * static_cast<float>(i);
    const Pack x = simd::load<Pack>(in);
    const Pack a = activate<kKind>(x);
    simd::store(out, a);
    simd::store(slopes, activation_slope<kKind>(x, a));
    for (int i = 0; i < kLanes; ++i) {
      const float one = activate<kKind>(in[i]);
      const double tolerance = kContraction * (1.0 + std::fabs(v));
      EXPECT_NEAR(static_cast<double>(out[i]), static_cast<double>(one), tolerance);
      EXPECT_NEAR(static_cast<double>(slopes[i]), static_cast<double>(activation_slope<kKind>(in[i], one)), tolerance);
    }
  });
}

TEST(Activation, APackEqualsItsLanesOneByOne) {
  expect_packs_agree<Activation::kTanh>();
  expect_packs_agree<Activation::kRelu>();
  expect_packs_agree<Activation::kSilu>();
}

}  // namespace
}  // namespace nlo
