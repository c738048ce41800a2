// SPDX-License-Identifier: MIT
// The observers (15) and (11): compared with the matrix exponential if they are linear, and by their order of
// convergence otherwise.
#include <nlo/eigen.h>
#include <nlo/general_observer.h>
#include <nlo/luenberger_observer.h>

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

#include "tests/runtime/linear_oracles.h"
#include "tests/runtime/structures.h"

namespace nlo {
namespace {

using testing::general_model;
using testing::luenberger_model;

/// Closed form over h of x' = A_e x + G y, with y a ramp from y0 to y1: the exponential of the system of [x; y; y'].
Eigen::Vector2d exact_step(const Eigen::Vector2d& x, double y0, double y1, double h) {
  Eigen::Matrix4d system = Eigen::Matrix4d::Zero();
  for (int i = 0; i < 2; ++i) {
    for (int k = 0; k < 2; ++k) system(i, k) = testing::kErrorMatrix[i][k];
    system(i, 2) = testing::kGain[i];
  }
  system(2, 3) = 1.0;
  const Eigen::Vector4d start(x(0), x(1), y0, (y1 - y0) / h);
  return (testing::exponential(system * h) * start).head<2>();
}

double output_at(int k) {
  return std::sin(0.13 * k) + 0.2 * std::cos(0.31 * k);
}

/// Largest |z - closed form| over 200 samples.
template <class Observer, class Model>
double distance_to_closed_form(const Model& model, Hold hold) {
  Observer observer(model);
  EXPECT_EQ(observer.step(static_cast<typename Model::Scalar>(output_at(0))), StepStatus::kOk);
  Eigen::Vector2d exact(testing::kInitial[0], testing::kInitial[1]);
  double worst = 0.0;
  for (int k = 1; k <= 200; ++k) {
    EXPECT_EQ(observer.step(static_cast<typename Model::Scalar>(output_at(k))), StepStatus::kOk);
    const double from = output_at(k - 1), to = hold == Hold::kZeroOrder ? from : output_at(k);
    exact = exact_step(exact, from, to, 0.02);
    const auto z = observer.latent();
    worst = std::fmax(worst, (as_eigen(z).template cast<double>() - exact).cwiseAbs().maxCoeff());
  }
  return worst;
}

// One RK4 step errs by (|A_e| h)^5 / 120 = (6.7 * 0.02)^5 / 120 = 4e-7 of |x| ~ 1; this decays with 1 / 1.65 s, 30
// steps.
constexpr double kRungeKutta = 1.2e-5;
constexpr double kInFloat = 2e-5;  // and about a hundred roundings of 6e-8

template <class Make>
void expect_closed_form(const Make& make) {
  for (const Hold hold : {Hold::kZeroOrder, Hold::kFirstOrder, Hold::kRk4}) {
    auto wide = make(0.0);
    wide.hold = hold;
    EXPECT_LT((distance_to_closed_form<SampledObserver<decltype(wide)>>(wide, hold)), kRungeKutta);
  }
}

TEST(LuenbergerObserver, EqualsTheMatrixExponentialIfItIsLinear) {
  expect_closed_form([](double scale) { return luenberger_model<double>(scale); });
  const auto narrow = luenberger_model<float>(0.0);
  EXPECT_LT((distance_to_closed_form<LuenbergerObserver<decltype(narrow)>>(narrow, Hold::kFirstOrder)), kInFloat);
  const auto control = luenberger_model<double>(0.01);  // a network with weights of a hundredth is detected
  EXPECT_GT((distance_to_closed_form<LuenbergerObserver<decltype(control)>>(control, Hold::kFirstOrder)), 1e-4);
}

TEST(GeneralObserver, EqualsTheMatrixExponentialIfFIsLinear) {
  expect_closed_form([](double scale) { return general_model<double>(scale); });
  const auto narrow = general_model<float>(0.0);
  EXPECT_LT((distance_to_closed_form<GeneralObserver<decltype(narrow)>>(narrow, Hold::kFirstOrder)), kInFloat);
  const auto control = general_model<double>(0.01);
  EXPECT_GT((distance_to_closed_form<GeneralObserver<decltype(control)>>(control, Hold::kFirstOrder)), 1e-4);
}

TEST(LuenbergerObserver, ConvergesToTheTrueStateOfAKnownPlant) {
  // x1' = x2, x2' = -4 x1 - 0.3 x2 and y = x1 is A = A_e + G C of the model above: the error is exp(A_e t) e_0.
  constexpr double kHoldError = 2e-4;  // linear interpolation of y between samples: (2 * 0.02)^2 / 12 of |G y| ~ 3
  const auto model = luenberger_model<double>(0.0);
  LuenbergerObserver observer(model);
  const Eigen::Matrix2d plant = (Eigen::Matrix2d() << 0, 1, -4, -0.3).finished();
  const Eigen::Matrix2d flow = testing::exponential(plant * 0.02);
  Eigen::Vector2d x(1.0, 0.0);
  for (int k = 0; k <= 500; ++k) {
    ASSERT_EQ(observer.step(x(0)), StepStatus::kOk);
    if (k < 500) x = flow * x;
  }
  const auto x_hat = observer.estimate();
  EXPECT_LT((as_eigen(x_hat) - x).norm(), kHoldError);
}

/// Returns z after 1 s of y = 0.5 - 2 t (a ramp for any sample period), with `steps` samples.
template <class Model>
Eigen::Vector2d after_a_second(const Model& pattern, int steps) {
  Model model = pattern;
  model.sample_period_s = 1.0 / steps;
  SampledObserver<Model> observer(model);
  for (int k = 0; k <= steps; ++k) EXPECT_EQ(observer.step(0.5 - 2.0 * k / steps), StepStatus::kOk);
  const auto z = observer.latent();
  return as_eigen(z);
}

template <class Model>
double order_of(const Model& model) {
  const Eigen::Vector2d exact = after_a_second(model, 2048);
  return std::log2((after_a_second(model, 32) - exact).norm() / (after_a_second(model, 64) - exact).norm());
}

TEST(NonlinearObservers, ConvergeAtOrderFour) {
  constexpr double kOrderTolerance = 0.2;  // the network is not infinitely smooth on the scale of 1/32 s
  EXPECT_NEAR(order_of(luenberger_model<double>(1.0)), 4.0, kOrderTolerance);
  EXPECT_NEAR(order_of(general_model<double>(1.0)), 4.0, kOrderTolerance);
}

template <class Model>
void expect_gaps_in_pieces(const Model& model) {
  constexpr double kRounding = 1e-14;
  SampledObserver<Model> once(model), often(model);
  ASSERT_EQ(once.step(1.0), StepStatus::kOk);
  ASSERT_EQ(often.step(1.0), StepStatus::kOk);
  ASSERT_EQ(once.step(-1.0, 0.2), StepStatus::kStale);
  for (int k = 1; k <= 10; ++k) ASSERT_EQ(often.step(1.0 - 0.2 * k), StepStatus::kOk);
  for (int r = 0; r < 2; ++r) EXPECT_NEAR(once.latent()[r], often.latent()[r], kRounding);
}

TEST(NonlinearObservers, StepOverAGapEqualsStepsOverItsSamples) {
  expect_gaps_in_pieces(luenberger_model<double>());
  expect_gaps_in_pieces(general_model<double>());
}

}  // namespace
}  // namespace nlo
