// SPDX-License-Identifier: MIT
// The driven observer (24)-(25): without an input it equals the plain observer bit for bit; with an input it converges
// at order 4, and on a linear plant to the true state.
#include <nlo/driven_kkl_observer.h>
#include <nlo/eigen.h>

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <type_traits>

#include "tests/runtime/linear_oracles.h"
#include "tests/runtime/structures.h"

namespace nlo {
namespace {

using testing::driven_model;
using testing::undriven_model;

template <class Scalar, Arithmetic kArithmetic>
void expect_plain_recurrence(Hold hold) {
  const auto driven = driven_model<Scalar>(hold, Hold::kFirstOrder);
  const auto plain = undriven_model<Scalar>(hold);
  DrivenKklObserver<std::remove_const_t<decltype(driven)>, kArithmetic> with(driven);
  KklObserver<std::remove_const_t<decltype(plain)>, kArithmetic> without(plain);
  for (int k = 0; k < 300; ++k) {
    const auto y = static_cast<Scalar>(3 * std::sin(0.2 * k));
    if (k % 10 == 7) {  // up to one and a half sample periods
      const auto dt_s = static_cast<Scalar>(0.004 + 0.0025 * (k % 11));
      ASSERT_EQ(with.step({{y}}, {}, dt_s), without.step(y, dt_s));
    } else {
      ASSERT_EQ(with.step({{y}}, {}), without.step(y));
    }
    for (int r = 0; r < 3; ++r) ASSERT_EQ(with.latent()[r], without.latent()[r]) << k;
    for (int i = 0; i < 2; ++i) ASSERT_EQ(with.estimate()[i], without.estimate()[i]) << k;
  }
}

TEST(DrivenKklObserver, WithoutAnInputEqualsThePlainObserverBitForBit) {
  for (const Hold hold : {Hold::kZeroOrder, Hold::kFirstOrder, Hold::kRk4}) {
    expect_plain_recurrence<float, Arithmetic::kFast>(hold);
    expect_plain_recurrence<double, Arithmetic::kFast>(hold);
    expect_plain_recurrence<float, Arithmetic::kDeterministic>(hold);
    expect_plain_recurrence<double, Arithmetic::kDeterministic>(hold);
  }
}

TEST(DrivenKklObserver, AnInputChangesTheEstimate) {  // control of the test above
  const auto model = driven_model<float>(Hold::kFirstOrder, Hold::kZeroOrder);
  DrivenKklObserver with(model), without(model);
  for (int k = 0; k < 10; ++k) {
    ASSERT_EQ(with.step({{1.0F}}, {{0.1F, 0.0F}}), StepStatus::kOk);
    ASSERT_EQ(without.step({{1.0F}}, {{0.0F, 0.0F}}), StepStatus::kOk);
  }
  EXPECT_GT(std::fabs(with.latent()[0] - without.latent()[0]), 1e-3F);
}

/// Returns z after 1 s of ramps in y and u (ramps for any sample period), with `steps` samples.
Eigen::Vector3d after_a_second(int steps) {
  auto model = driven_model<double>(Hold::kFirstOrder, Hold::kFirstOrder);
  model.sample_period_s = 1.0 / steps;
  model.latent.step =
      discretise<1>(Hold::kFirstOrder, model.latent.eigenvalues, model.latent.output_injection, 1.0 / steps);
  model.forced =
      forced_step<1>(Hold::kFirstOrder, model.latent.eigenvalues, model.latent.output_injection, 1.0 / steps);
  DrivenKklObserver observer(model);
  for (int k = 0; k <= steps; ++k) {
    const double t = static_cast<double>(k) / steps;
    EXPECT_EQ(observer.step({{0.5 - 2.0 * t}}, {{2.0 * t, 1.0 - t}}), StepStatus::kOk);
  }
  const auto z = observer.latent();
  return as_eigen(z);
}

TEST(DrivenKklObserver, ConvergesAtOrderFour) {
  constexpr double kOrderTolerance = 0.2;
  const Eigen::Vector3d exact = after_a_second(2048);
  EXPECT_NEAR(std::log2((after_a_second(32) - exact).norm() / (after_a_second(64) - exact).norm()), 4.0,
              kOrderTolerance);
}

TEST(DrivenKklObserver, DriveIsTheJacobianTimesTheInputField) {
  // Slopes are those of tanh, values those of a rational function within 4e-8.
  constexpr double kStep = 1e-5, kTolerance = 1e-6;
  const auto model = driven_model<double>(Hold::kFirstOrder, Hold::kZeroOrder);
  const double z[3] = {0.4, -0.2, 0.9}, y[1] = {0.7}, u[2] = {1.5, -0.5};
  double driven[3], x[2], dx[2], ahead[2], behind[2], high[3], low[3];
  model.drive(z, y, u, driven);
  model.estimate(z, y, x);
  for (int k = 0; k < 2; ++k) {  // g(x) u from its definition
    dx[k] = 0.0;
    for (int i = 0; i < 2; ++i) {
      dx[k] += u[i] * (model.input_field.constant[i][k] + model.input_field.linear[i][k][0] * x[0] +
                       model.input_field.linear[i][k][1] * x[1]);
    }
    ahead[k] = x[k] + kStep * dx[k];
    behind[k] = x[k] - kStep * dx[k];
  }
  model.forward_map.evaluate(ahead, high);
  model.forward_map.evaluate(behind, low);
  for (int r = 0; r < 3; ++r) EXPECT_NEAR(driven[r], (high[r] - low[r]) / (2 * kStep), kTolerance);
}

TEST(DrivenKklObserver, OneLongStepEqualsManyStepsOfOnePeriod) {
  constexpr double kRounding = 1e-13;
  const auto model = driven_model<double>(Hold::kFirstOrder, Hold::kFirstOrder);
  DrivenKklObserver once(model), often(model);
  ASSERT_EQ(once.step({{1.0}}, {{0.0, 1.0}}), StepStatus::kOk);
  ASSERT_EQ(often.step({{1.0}}, {{0.0, 1.0}}), StepStatus::kOk);
  ASSERT_EQ(once.step({{-1.0}}, {{2.0, 0.0}}, 0.2), StepStatus::kStale);
  for (int k = 1; k <= 10; ++k) ASSERT_EQ(often.step({{1.0 - 0.2 * k}}, {{0.2 * k, 1.0 - 0.1 * k}}), StepStatus::kOk);
  for (int r = 0; r < 3; ++r) EXPECT_NEAR(once.latent()[r], often.latent()[r], kRounding);
}

/// x1' = x2, x2' = -x1 + u, y = x1 and a linear T: T A = D T + F C, phi(z) u = T B u for every z.
struct DrivenOscillator {
  static constexpr double kPeriod = 1e-3;
  using Linear = Mlp<Activation::kTanh, PackedDense<double, 2, 2>>;
  using Model = DrivenKklModel<double, 2, 1, 2, 1, 0, LearnedMap<Linear>, LearnedMap<Linear>>;
  Model model{};

  /// `input_gain` 1: as in the plant.
  explicit DrivenOscillator(double input_gain) {
    const double lambda[2] = {-2.0, -5.0};
    Eigen::Matrix2d t;  // row i: lambda_i T_i + C = T_i A
    for (int i = 0; i < 2; ++i) {
      const Eigen::Matrix2d a = (Eigen::Matrix2d() << 0, 1, -1, 0).finished();
      t.row(i) =
          Eigen::RowVector2d(1, 0) * testing::inverse(Eigen::MatrixXd(a - lambda[i] * Eigen::Matrix2d::Identity()));
      model.latent.eigenvalues[i] = lambda[i];
      model.latent.output_injection[i][0] = 1.0;
    }
    testing::set_sampling(model);
    model.sample_period_s = kPeriod;
    model.latent.hold = Hold::kFirstOrder;
    testing::complete(model);
    model.forced = forced_step<0>(Hold::kFirstOrder, model.latent.eigenvalues, model.latent.output_injection, kPeriod);
    model.input_hold = Hold::kZeroOrder;
    model.input_field.constant[0][1] = input_gain;
    const Eigen::Matrix2d inverse = testing::inverse(Eigen::MatrixXd(t));
    Dense<double, 2, 2> back{}, forward{};
    for (int o = 0; o < 2; ++o) {
      for (int i = 0; i < 2; ++i) {
        back.weights[o][i] = inverse(o, i);
        forward.weights[o][i] = t(o, i);
      }
    }
    model.inverse_map.mlp = make_mlp<Activation::kTanh>(back);
    model.forward_map.mlp = make_mlp<Activation::kTanh>(forward);
  }

  /// Largest error from 5 s to 6 s, under u = 2 cos 12 t held over each sample period.
  double settled_error() const {
    Eigen::Matrix3d system = Eigen::Matrix3d::Zero();
    system(0, 1) = 1.0;
    system(1, 0) = -1.0;
    system(1, 2) = 1.0;
    const Eigen::Matrix3d flow = testing::exponential(system * kPeriod);
    DrivenKklObserver observer(model);
    Eigen::Vector3d x(1.0, 0.0, 0.0);
    double worst = 0.0;
    for (int k = 0; k <= 6000; ++k) {
      EXPECT_EQ(observer.step(x(0), x(2)), StepStatus::kOk);  // the input that has acted since the last sample
      const auto x_hat = observer.estimate();
      if (k >= 5000) worst = std::fmax(worst, (as_eigen(x_hat) - x.head<2>()).norm());
      x(2) = 2.0 * std::cos(12.0 * k * kPeriod);
      x.head<2>() = (flow * x).head<2>();
    }
    return worst;
  }
};

TEST(DrivenKklObserver, ConvergesToTheTrueStateOfADrivenLinearPlant) {
  // exp(-2 * 5) of the initial error is left, 5e-5 times |T*| |T x|, about 2; linear interpolation of y errs by h^2 /
  // 12.
  EXPECT_LT(DrivenOscillator(1.0).settled_error(), 2e-4);
  EXPECT_GT(DrivenOscillator(0.0).settled_error(), 2e-2) << "the control: an observer that ignores u";
  EXPECT_GT(DrivenOscillator(0.9).settled_error(), 2e-3) << "the control: a tenth of u ignored";
}

}  // namespace
}  // namespace nlo
