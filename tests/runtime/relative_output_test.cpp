// SPDX-License-Identifier: MIT
// Outputs that T* reads only as z - S y: an encoder that counts turns without end. They are not clamped: whole
// multiples of W are subtracted from y and from z (measurement.h, steady_state.h). A DC motor is a linear plant, so T
// has a closed form: T A = D T + F C and F_u = T B, and x = R^-1 (z - y) with R the columns of T except that of the
// angle.
#include <nlo/kkl_batch.h>
#include <nlo/kkl_observer.h>

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/runtime/batch_twin.h"
#include "tests/runtime/linear_oracles.h"
#include "tests/runtime/testing.h"

namespace nlo {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector4d = Eigen::Vector4d;

constexpr double kPeriod_s = 1e-3, kWrap = 4096.0, kDeclared = 1000.0;  // rad

/// States: angle, speed, current, load. R = 1 Ohm, L = 2 mH, k = 40 mN m/A, J = 1e-4 kg m^2, b = 1e-5 N m s.
struct Motor {
  Matrix a = (Matrix(4, 4) << 0, 1, 0, 0, 0, -0.1, 400, -1e4, 0, -20, -500, 0, 0, 0, 0, 0).finished();
  Vector4d b{0, 0, 500, 0};
  Matrix step_a = Matrix::Identity(4, 4);  // over one sample period, exact
  Vector4d step_b = Vector4d::Zero();

  Motor() {
    Matrix term = Matrix::Identity(4, 4);  // (A h)^k / k!
    for (int k = 1; k < 30; ++k) {
      step_b += term * b * (kPeriod_s / k);
      term = term * a * (kPeriod_s / k);
      step_a += term;
    }
  }
};

template <class Scalar>
using EncoderModel = KklModel<Scalar, 3, 1, 3, 0, LearnedMap<Mlp<Activation::kTanh, PackedDense<Scalar, 5, 3>>>, 1>;

template <class Scalar>
EncoderModel<Scalar> encoder_model(double wrap = kWrap) {
  constexpr double kRates[3] = {60.0, 90.0, 140.0};
  const Motor motor;
  EncoderModel<Scalar> model{};
  model.sample_period_s = Scalar(kPeriod_s);
  model.stale_after = 7;
  model.latent.hold = Hold::kFirstOrder;
  model.latent.starts_steady = true;
  model.latent.relative[0] = true;
  Matrix t(3, 4);
  for (int r = 0; r < 3; ++r) {  // t (A + p I) = p C
    const Matrix shifted = motor.a + kRates[r] * Matrix::Identity(4, 4);
    t.row(r) = testing::solve(shifted.transpose(), kRates[r] * Vector4d::Unit(0)).transpose();
    model.latent.eigenvalues[r] = Scalar(-kRates[r]);
    model.latent.output_injection[r][0] = Scalar(kRates[r]);
    model.latent.output_injection[r][1] = static_cast<Scalar>(t.row(r).dot(motor.b));
  }
  const Matrix inverse = testing::solve(t.rightCols(3), Matrix::Identity(3, 3));
  Dense<Scalar, 5, 3> layer{};
  for (int i = 0; i < 3; ++i) {
    for (int r = 0; r < 3; ++r) layer.weights[i][r] = static_cast<Scalar>(inverse(i, r));
    layer.weights[i][3] = static_cast<Scalar>(-inverse.row(i).sum());
  }
  model.inverse_map.mlp = make_mlp<Activation::kTanh>(layer);
  model.outputs.wrap[0] = static_cast<Scalar>(wrap);
  model.outputs.max[0] = static_cast<Scalar>(wrap > 0.0 ? 64.0 * wrap : kDeclared);
  model.outputs.max[1] = Scalar(24);
  for (int j = 0; j < 2; ++j) model.outputs.min[j] = -model.outputs.max[j];
  const Eigen::Vector3d reach = t.rightCols(3).cwiseAbs() * Eigen::Vector3d(400.0, 30.0, 0.5);
  for (int r = 0; r < 3; ++r) {
    model.domain.latent_max[r] = static_cast<Scalar>(reach(r));
    model.domain.latent_min[r] = -model.domain.latent_max[r];
  }
  testing::complete(model);
  return model;
}

enum class Count { kAll, kModulo };  // readings of the encoder: all turns, or modulo W

struct Flown {
  double worst_speed = 0.0;  ///< largest error of the speed after the first 0.2 s [rad/s]
  double worst_latent = 0.0;
  StepStatus worst = StepStatus::kOk;
  bool left_domain = false;
};

/// Runs the motor at 120 rad/s, 20 rad/s up and down, for `seconds`.
template <Arithmetic kArithmetic, class Scalar>
Flown fly(const EncoderModel<Scalar>& model, Count count, double seconds) {
  const Motor motor;
  KklObserver<EncoderModel<Scalar>, kArithmetic> observer(model);
  Vector4d x{0.5, 120.0, 0.03, 0.0};
  Flown flown;
  const auto samples = static_cast<int>(seconds / kPeriod_s);
  for (int k = 0; k < samples; ++k) {
    const double voltage = 4.83 + 0.8 * std::sin(5e-3 * k);
    const double read = count == Count::kAll ? x[0] : std::remainder(x[0], kWrap);
    const StepStatus status = observer.step({{static_cast<Scalar>(read)}}, {{static_cast<Scalar>(voltage)}});
    flown.worst = std::max(flown.worst, status);
    flown.left_domain = flown.left_domain || !observer.in_domain();
    for (const Scalar z : observer.latent())
      flown.worst_latent = std::max(flown.worst_latent, std::fabs(static_cast<double>(z)));
    if (k * kPeriod_s > 0.2)
      flown.worst_speed = std::max(flown.worst_speed, std::fabs(static_cast<double>(observer.estimate()[0]) - x[1]));
    x = motor.step_a * x + motor.step_b * voltage;
  }
  return flown;
}

// Float has steps of 2^-14 rad at 1,000 rad and of 2^-12 rad at 2,048 rad. T* has three modes within a factor of 2.3,
// which amplifies these to 0.6 and 1.3 rad/s.
constexpr double kAsInTheFirstSeconds = 1.0, kAsInTheFirstTurn = 2.0;

TEST(RelativeOutput, FollowsAnEncoderAt120RadPerSecondFor20Minutes) {
  const auto model = encoder_model<float>();
  const auto check = [&]<Arithmetic kArithmetic> {
    const Flown short_flight = fly<kArithmetic>(model, Count::kAll, 8.0);
    EXPECT_LT(short_flight.worst_speed, kAsInTheFirstSeconds);
    const Flown modulo = fly<kArithmetic>(model, Count::kModulo, 1200.0);
    EXPECT_EQ(modulo.worst, StepStatus::kOk);
    EXPECT_FALSE(modulo.left_domain);
    EXPECT_LT(modulo.worst_speed, kAsInTheFirstTurn) << "as in the first 20 seconds: the error does not grow";
    EXPECT_LT(modulo.worst_latent, 0.51 * kWrap + 10.0);
    // At 144,000 rad, float itself has steps of 2^-6 rad.
    const Flown all = fly<kArithmetic>(model, Count::kAll, 1200.0);
    EXPECT_EQ(all.worst, StepStatus::kOk);
    EXPECT_FALSE(all.left_domain);
    EXPECT_LT(all.worst_speed, 6.0);
  };
  check.operator()<Arithmetic::kFast>();
  check.operator()<Arithmetic::kDeterministic>();
}

TEST(RelativeOutput, IsClampedAndReportedIfItHasNoWrap) {
  const Flown clamped = fly<Arithmetic::kFast>(encoder_model<float>(0.0), Count::kAll, 20.0);
  EXPECT_EQ(clamped.worst, StepStatus::kOutOfRange);
  EXPECT_TRUE(clamped.left_domain);
  EXPECT_GT(clamped.worst_speed, 100.0) << "control: clamping makes the speed wrong";
}

TEST(RelativeOutput, InDoubleEqualsTheClosedForm) {
  const Flown flown = fly<Arithmetic::kFast>(encoder_model<double>(), Count::kAll, 120.0);
  EXPECT_EQ(flown.worst, StepStatus::kOk);
  EXPECT_LT(flown.worst_speed, 0.05) << "the error of linear interpolation between samples";
}

TEST(RelativeOutput, TheWrapChangesNoBitWithinTheDeclaredRange) {
  const auto model = encoder_model<float>(), clamping = encoder_model<float>(0.0);
  KklObserver wrapping(model), plain(clamping);
  std::mt19937 random(3);
  for (int k = 0; k < 20000; ++k) {
    const auto y = testing::uniform<float>(random, -kDeclared, kDeclared), u = testing::uniform<float>(random, -24, 24);
    ASSERT_EQ(wrapping.step({{y}}, {{u}}), StepStatus::kOk);
    ASSERT_EQ(plain.step({{y}}, {{u}}), StepStatus::kOk);
    ASSERT_TRUE(testing::same_bits(wrapping.save(), plain.save())) << k;
  }
}

TEST(RelativeOutput, AddingAnyNumberOfWrapsChangesNoBit) {
  const auto model = encoder_model<float>();
  KklObserver near(model), far(model);
  std::mt19937 random(4);
  for (int k = 0; k < 20000; ++k) {  // multiples of 2^-4, which are also exact 60 W further
    const float y = std::round(16.0F * testing::uniform<float>(random, -kDeclared, kDeclared)) / 16.0F;
    const auto wraps = static_cast<float>(static_cast<int>(random() % 121) - 60);
    ASSERT_EQ(near.step({{y}}, {{1.0F}}), StepStatus::kOk);
    ASSERT_EQ(far.step({{y + wraps * static_cast<float>(kWrap)}}, {{1.0F}}), StepStatus::kOk);
    ASSERT_TRUE(testing::same_bits(near.save(), far.save())) << k;
  }
}

TEST(RelativeOutput, IsHeldBeyondItsAcceptedRangeOrIfNotFinite) {
  const auto model = encoder_model<float>();
  KklObserver observer(model);
  ASSERT_EQ(observer.step({{5.0F}}, {{0.0F}}), StepStatus::kOk);
  const auto limit = static_cast<float>(64.0 * kWrap);
  for (const float bad : {std::nextafter(limit, 1e30F), -1e30F, std::numeric_limits<float>::infinity(),
                          std::numeric_limits<float>::quiet_NaN()}) {
    EXPECT_EQ(observer.step({{bad}}, {{0.0F}}), StepStatus::kHeld) << bad;
    EXPECT_EQ(observer.save().y[0], 5.0F);
    EXPECT_EQ(observer.step({{5.0F}}, {{0.0F}}), StepStatus::kOk);
  }
  EXPECT_EQ(observer.step({{limit}}, {{0.0F}}), StepStatus::kOk);
  EXPECT_EQ(observer.save().y[0], 0.0F);
}

TEST(RelativeOutput, InABatchEqualsThatOfASingleObserver) {
  constexpr int kPlants = 37;
  const auto model = encoder_model<float>(64.0);
  std::mt19937 random(8);
  // Encoders that turn by 20 rad per sample, each in another turn; sometimes all are at rest near zero, or one is
  // missing.
  const auto reading = [&random](int k, int plant, int channel) {
    if (channel == 1) return 0.0F;
    if (k % 7 < 3) return 10.0F + 0.25F * static_cast<float>(plant);
    if (random() % 16 == 0) return std::numeric_limits<float>::quiet_NaN();
    return static_cast<float>(k) * 20.0F + static_cast<float>(plant) * 8.0F;
  };
  EXPECT_LE(testing::off_observers<kPlants>(KklBatch<EncoderModel<float>, kPlants>(model), KklObserver(model), reading),
            0.05F);
}

}  // namespace
}  // namespace nlo
