// SPDX-License-Identifier: MIT
// Known inputs as readings: the latent system follows y and u exactly with each hold; a bad input is held or clamped
// like a bad output; a batch equals as many single observers.
#include <nlo/general_observer.h>
#include <nlo/kkl_batch.h>
#include <nlo/luenberger_observer.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/runtime/batch_twin.h"

namespace nlo {
namespace {

using testing::identity_map;

constexpr double kMissed = std::numeric_limits<double>::quiet_NaN();

/// y drives row 0 and u row 1: one real mode each with unit gain, T* = z.
template <class Scalar, Hold kInputHold>
using TwoModes = KklModel<Scalar, 2, 1, 2, 0, decltype(identity_map<Scalar, 2>()), 1, kInputHold>;

template <class Scalar, Hold kInputHold>
constexpr TwoModes<Scalar, kInputHold> two_modes(Hold hold, bool starts_steady = false) {
  TwoModes<Scalar, kInputHold> m{};
  m.sample_period_s = Scalar(0.05);
  m.stale_after = 3;
  m.latent.hold = hold;
  m.latent.eigenvalues[0] = Scalar(-2);
  m.latent.eigenvalues[1] = Scalar(-3);
  m.latent.output_injection[0][0] = Scalar(2);
  m.latent.output_injection[1][1] = Scalar(3);
  m.latent.starts_steady = starts_steady;
  for (int j = 0; j < 2; ++j) {
    m.outputs.min[j] = Scalar(-10);
    m.outputs.max[j] = Scalar(10);
    m.domain.latent_min[j] = Scalar(-10);
    m.domain.latent_max[j] = Scalar(10);
  }
  m.inverse_map = identity_map<Scalar, 2>();
  testing::complete(m);
  return m;
}

/// z over h with constant u: z' = -3 z + 3 u.
double held(double z, double u, double h) {
  return u + (z - u) * std::exp(-3.0 * h);
}

TEST(KnownInputs, ACommandActsOverTheIntervalBeforeItsSampleExactly) {
  // For each hold of y. RK4's coefficients are exact only to its order: h^5 lambda^5 / 120 = 6e-7 a step.
  for (const Hold hold : {Hold::kZeroOrder, Hold::kFirstOrder, Hold::kRk4}) {
    const auto model = two_modes<double, Hold::kZeroOrder>(hold);
    KklObserver observer(model);
    ASSERT_EQ(observer.step(0.0, 7.0), StepStatus::kOk);  // starts the observer
    double z = 0.0;
    for (int k = 0; k < 40; ++k) {
      const double u = k % 7 - 3.0;
      z = held(z, u, 0.05);
      ASSERT_EQ(observer.step(0.1 * k, u), StepStatus::kOk);
      ASSERT_NEAR(observer.latent()[1], z, hold == Hold::kRk4 ? 2e-5 : 1e-14) << k;
    }
  }
}

TEST(KnownInputs, ACommandAlsoActsOverAnIrregularStep) {
  const auto model = two_modes<double, Hold::kZeroOrder>(Hold::kFirstOrder);
  KklObserver observer(model);
  ASSERT_EQ(observer.step(0.0, 0.0), StepStatus::kOk);
  ASSERT_EQ(observer.step(0.0, 5.0, 0.12), StepStatus::kHeld);
  EXPECT_NEAR(observer.latent()[1], held(0.0, 5.0, 0.12), 1e-14);
}

TEST(KnownInputs, AMeasuredInputIsInterpolatedLikeTheOutputs) {
  const auto model = two_modes<double, Hold::kFirstOrder>(Hold::kFirstOrder);
  KklObserver observer(model);
  // z' = 3 (u - z), u = t: z = t - 1/3 + exp(-3 t) / 3 from 0.
  ASSERT_EQ(observer.step(0.0, 0.0), StepStatus::kOk);
  for (int k = 1; k <= 40; ++k) ASSERT_EQ(observer.step(0.0, 0.05 * k), StepStatus::kOk);
  EXPECT_NEAR(observer.latent()[1], 2.0 - 1.0 / 3.0 + std::exp(-6.0) / 3.0, 1e-13);
}

TEST(KnownInputs, ABadInputIsHeldOrClampedAndCounted) {
  const auto model = two_modes<double, Hold::kZeroOrder>(Hold::kFirstOrder);
  KklObserver observer(model);
  EXPECT_EQ(observer.step(0.0, kMissed), StepStatus::kHeld);  // no value to start from
  ASSERT_EQ(observer.step(0.0, 4.0), StepStatus::kOk);
  EXPECT_EQ(observer.step(1.0, kMissed), StepStatus::kHeld);
  EXPECT_NEAR(observer.latent()[1], held(0.0, 4.0, 0.05), 1e-14);  // the last good input, 4 V
  EXPECT_EQ(observer.save().y[0], 1.0);                            // y is still used
  EXPECT_EQ(observer.step(1.0, 50.0), StepStatus::kClamped);
  EXPECT_EQ(observer.save().y[1], 10.0);
  EXPECT_EQ(observer.step_missed({{2.0}}), StepStatus::kHeld);  // the command is still known
  EXPECT_EQ(observer.save().y[1], 2.0);
  for (int k = 0; k < 2; ++k) EXPECT_EQ(observer.step(1.0, kMissed), StepStatus::kHeld);
  EXPECT_EQ(observer.step(1.0, kMissed), StepStatus::kStale);
}

/// Three readings, kNu of which are inputs: one real mode each with unit gain, T* = z.
template <int kNu>
using ThreeModes = KklModel<double, 3, 3 - kNu, 3, 0, decltype(identity_map<double, 3>()), kNu>;

template <int kNu>
ThreeModes<kNu> three_modes() {
  ThreeModes<kNu> m{};
  m.sample_period_s = 0.05;
  m.stale_after = 3;
  m.latent.hold = Hold::kFirstOrder;
  for (int r = 0; r < 3; ++r) {
    m.latent.eigenvalues[r] = -1.0 - r;
    m.latent.output_injection[r][r] = 1.0 + r;
    m.outputs.min[r] = m.domain.latent_min[r] = -10.0;
    m.outputs.max[r] = m.domain.latent_max[r] = 10.0;
  }
  m.inverse_map = identity_map<double, 3>();
  testing::complete(m);
  return m;
}

TEST(KnownInputs, ASingleInputOrOutputNeedsNoBraces) {
  const auto one_input = three_modes<1>();
  KklObserver braces(one_input), plain(one_input);
  for (int k = 0; k < 5; ++k) {
    const double y = 0.1 * k, u = 1.0 - k;
    ASSERT_EQ(braces.step({{y, -y}}, {{u}}), plain.step({{y, -y}}, u));
    ASSERT_EQ(braces.step({{y, -y}}, {{u}}, 0.06), plain.step({{y, -y}}, u, 0.06));
    for (int r = 0; r < 3; ++r) ASSERT_EQ(braces.latent()[r], plain.latent()[r]);
  }
  EXPECT_NE(plain.latent()[2], 0.0) << "control: the input is read";
  const auto one_output = three_modes<2>();
  KklObserver all_braces(one_output), scalar_output(one_output);
  for (int k = 0; k < 5; ++k) {
    ASSERT_EQ(all_braces.step({{0.1 * k}}, {{1.0, 2.0}}), scalar_output.step(0.1 * k, {{1.0, 2.0}}));
    ASSERT_EQ(all_braces.step({{0.1 * k}}, {{1.0, 2.0}}, 0.06), scalar_output.step(0.1 * k, {{1.0, 2.0}}, 0.06));
  }
  for (int r = 0; r < 3; ++r) EXPECT_EQ(all_braces.latent()[r], scalar_output.latent()[r]);
}

TEST(KnownInputs, AWarmStartIsTheSteadyStateOfOutputsAndInputs) {
  const auto model = two_modes<double, Hold::kZeroOrder>(Hold::kFirstOrder, true);
  KklObserver observer(model);
  ASSERT_EQ(observer.step(2.0, -4.0), StepStatus::kOk);
  EXPECT_DOUBLE_EQ(observer.latent()[0], 2.0);
  EXPECT_DOUBLE_EQ(observer.latent()[1], -4.0);
  ASSERT_EQ(observer.warm_start({{1.0}}, {{3.0}}), StepStatus::kOk);
  EXPECT_DOUBLE_EQ(observer.latent()[0], 1.0);
  EXPECT_DOUBLE_EQ(observer.latent()[1], 3.0);
}

TEST(KnownInputs, RefusesAStateWithAnImpossibleInput) {
  const auto model = two_modes<double, Hold::kZeroOrder>(Hold::kFirstOrder);
  KklObserver observer(model);
  ASSERT_TRUE(observer.reset({{0.5, 0.5}}, {{1.0}}, {{2.0}}));
  auto state = observer.save();
  state.y[1] = 11.0;
  EXPECT_FALSE(observer.restore(state));
  state.y[1] = kMissed;
  EXPECT_FALSE(observer.restore(state));
  EXPECT_FALSE(observer.reset({{0.5, 0.5}}, {{1.0}}, {{20.0}}));
  EXPECT_EQ(observer.save().y[1], 2.0);
}

template <Hold kInputHold>
float batch_off_observers() {
  constexpr int kPlants = 21;  // several blocks of plants and a shorter last block
  static constexpr auto kModel = two_modes<float, kInputHold>(Hold::kFirstOrder);
  using Model = std::remove_cvref_t<decltype(kModel)>;
  std::mt19937 random(3);
  return testing::off_observers<kPlants>(
      KklBatch<Model, kPlants, Arithmetic::kDeterministic>{kModel},
      KklObserver<Model, Arithmetic::kDeterministic>{kModel}, [&](int sample, int plant, int channel) {
        if (channel == 0) return testing::uniform<float>(random, -5, 5);
        return sample % 5 == 4 && plant % 6 == 1 ? std::numeric_limits<float>::quiet_NaN()
                                                 : testing::uniform<float>(random, -8, 12);
      });
}

TEST(KnownInputs, ABatchEqualsSingleObservers) {
  EXPECT_EQ(batch_off_observers<Hold::kZeroOrder>(), 0.0F);
  EXPECT_EQ(batch_off_observers<Hold::kFirstOrder>(), 0.0F);
}

/// 100 Hz, readings in +-100.
template <class Model>
Model sampled_at_100_hz() {
  Model m{};
  m.sample_period_s = 0.01;
  m.stale_after = 5;
  m.hold = Hold::kFirstOrder;
  for (int j = 0; j < 2; ++j) {
    m.outputs.min[j] = -100.0;
    m.outputs.max[j] = 100.0;
  }
  return m;
}

/// A linear map of kIn values to their weighted sum.
template <int kIn>
constexpr auto sum_of(const double (&weights)[kIn]) {
  Dense<double, kIn, 1> layer{};
  for (int i = 0; i < kIn; ++i) layer.weights[0][i] = weights[i];
  return LearnedMap<Mlp<Activation::kTanh, PackedDense<double, kIn, 1>>>{make_mlp<Activation::kTanh>(layer), {}};
}

TEST(KnownInputs, ALuenbergerObserverFollowsAPlantThatItsInputDrives) {
  // x' = -x + 2 u, y = x: with B = 2 only the initial error remains, exp(-(1 + G) t).
  using Map = decltype(sum_of<1>({0.0}));
  auto m = sampled_at_100_hz<LuenbergerModel<double, 1, 1, Map, 1>>();
  m.error_matrix[0][0] = -1.0 - 4.0;
  m.gain[0][0] = 4.0;
  m.gain[0][1] = 2.0;
  m.nonlinearity = sum_of<1>({0.0});
  LuenbergerObserver observer(m);
  double x = 3.0;
  for (int k = 0; k < 400; ++k) {
    const double u = std::sin(0.3 * k) > 0.0 ? 1.0 : -0.5;
    if (k > 0) x = 2.0 * u + (x - 2.0 * u) * std::exp(-0.01);
    ASSERT_EQ(observer.step(x, u), StepStatus::kOk);
  }
  EXPECT_NEAR(observer.estimate()[0], x, 3e-5);  // linear interpolation of y between samples errs by h^2 x'' / 12
}

TEST(KnownInputs, AGeneralObserverReadsThemAfterTheOutputs) {
  // F = -z + 10 u reads [z; y; u].
  using Dynamics = decltype(sum_of<3>({0.0, 0.0, 0.0}));
  using Map = decltype(sum_of<1>({0.0}));
  auto m = sampled_at_100_hz<GeneralModel<double, 1, 1, 1, Dynamics, Map, 1>>();
  m.dynamics = sum_of<3>({-1.0, 0.0, 10.0});
  m.inverse_map = sum_of<1>({1.0});
  GeneralObserver observer(m);
  double z = 0.0;
  for (int k = 0; k < 100; ++k) {
    const double u = k % 3 - 1.0;
    if (k > 0) z = 10.0 * u + (z - 10.0 * u) * std::exp(-0.01);
    ASSERT_EQ(observer.step(0.0, u), StepStatus::kOk);
    ASSERT_NEAR(observer.estimate()[0], z, 1e-9);  // RK4: h^5 / 120 of |z| a step
  }
}

}  // namespace
}  // namespace nlo
