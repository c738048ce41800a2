// SPDX-License-Identifier: MIT
// Nothing that is measured on a linear plant breaks the bound of Proposition 2, and what comes near to it does.
#include <gtest/gtest.h>

#include <cmath>
#include <ostream>
#include <string>
#include <vector>

#include "codegen/replay/reference_observer.h"
#include "tests/bounds/linear_plants.h"
#include "trainer/bounds/bound_text.h"

namespace nlo::trainer {
namespace {

TEST(Bound19, IsTheFormulaOfThePaper) {
  const Proposition2 p{2, 3, -0.5, 1.5, 0.8};
  const ErrorBound bound = bound_19(p, 2.0, 0.1, 0.3);
  const double factor = 8.0 * std::sqrt(2.0) * 1.5;
  EXPECT_NEAR(bound.at(0.7, 2.0), factor * std::exp(-0.7) * 2.0 + factor / 1.0 * (0.8 / 2.0 * 0.1 + 0.3), 1e-12);
}

TEST(ErrorBound, TransientEndsWhereAllOfItMeetsTheLevel) {
  const ErrorBound bound{3.0, -0.5, 0.2};
  const double t = bound.transient_s(2.0, 0.3);
  EXPECT_NEAR(bound.at(t, 2.0), 0.3, 1e-12);
  EXPECT_EQ(bound.transient_s(0.01, 0.3), 0.0);
  EXPECT_TRUE(std::isinf(bound.transient_s(2.0, 0.2))) << "it settles there, and comes no lower";
}

TEST(InjectedBound, IsReachedAtTheWorstCorner) {
  Eigen::Matrix2d f;
  f << 1.0, -2.0, 0.5, 1.0;
  EXPECT_NEAR(injected_bound(f, Eigen::Vector2d(1.0, 1.0)), std::hypot(3.0, 0.5), 1e-12);  // at (1, -1)
}

struct Case {
  const char* name;
  LinearPlant (*plant)();
  std::vector<double> eigenvalues;
  int pairs;

  friend void PrintTo(const Case& row, std::ostream* out) { *out << row.name; }
};

class LinearPlants : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Cases, LinearPlants,
                         testing::Values(Case{"scalar", scalar_plant, {-1.0}, 0},
                                         Case{"oscillator", oscillator, {-0.5, -1.0, -1.5}, 0},
                                         Case{"oscillator_pair", oscillator, {-0.4, 0.9}, 1},
                                         Case{"third_order", damped_third_order, {-0.9, 0.5, -1.2, -2.0}, 1}),
                         [](const auto& row) { return row.param.name; });

TEST_P(LinearPlants, NoMeasurementBreaksTheProvenBound) {
  const LinearPlant plant = GetParam().plant();
  const Eigen::VectorXd eigenvalues =
      Eigen::VectorXd::Map(GetParam().eigenvalues.data(), static_cast<Eigen::Index>(GetParam().eigenvalues.size()));
  for (const char* hold : {"first_order", "zero_order"}) {
    codegen::Model model = model_of(plant, eigenvalues, GetParam().pairs, hold);
    if (plant.ny() == 2) codegen::linear_latent(model)->output_injection << 1, 0, 0, 1, 1, 0, 0, 1;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      BoundTest test;
      test.trajectories = 6;
      test.seed = seed;
      test.noise = seed == 4 ? 0.0 : 0.5;
      test.disturbance = seed == 2 ? 0.0 : 0.2;
      test.threads = 1;
      for (const double k : {1.0, 3.0, 8.0}) {
        const BoundMeasurement measured = exact_result(plant, model, k, test).measured;
        EXPECT_LE(measured.ratio[kWeightsBound], 1.0) << hold << ", seed " << seed << ", k = " << k;
        EXPECT_GT(measured.ratio[kWeightsBound], 0.05) << "control: the bound is of the size of what it bounds";
      }
    }
  }
}

TEST(ProvenBound, NoiseMatchedToTheImpulseResponseKeepsToTheBound) {
  // The noise that drives one component of x_hat - x as far as |v| <= V allows: the sign of its impulse response,
  // reversed in time. Random noise never comes near it.
  const LinearPlant plant = oscillator();
  const codegen::Model model = model_of(plant, Eigen::Vector3d(-0.5, -1.0, -1.5));
  BoundTest test;
  test.trajectories = 4;
  test.noise = 0.5;
  const SimulationConfig simulation = simulation_of(plant, 30.0);
  const BoundStudy study(plant, model, simulation, test);
  for (const double k : {1.0, 4.0}) {
    const codegen::Model observer = study.exact_observer(k);
    const BoundResult result = study.at(k, observer, "");
    const Eigen::MatrixXd& inverse = codegen::inverse_map(observer)->layers[0].weights;
    constexpr Eigen::Index kSamples = 1501;
    double worst = 0.0;
    for (double angle = 0.0; angle < 3.14; angle += 0.2) {
      const Eigen::RowVectorXd component = Eigen::RowVector2d(std::cos(angle), std::sin(angle)) * inverse;
      Eigen::MatrixXd v(1, kSamples);
      for (Eigen::Index n = 0; n < kSamples; ++n) {
        const double ago_s = 0.02 * static_cast<double>(kSamples - 1 - n);
        const Eigen::VectorXd impulse = (codegen::linear_latent(observer)->eigenvalues * ago_s).array().exp() *
                                        codegen::linear_latent(observer)->output_injection.col(0).array();
        v(0, n) = component * impulse >= 0.0 ? test.noise : -test.noise;
      }
      // The plant at rest: the estimate is the error.
      const Eigen::VectorXd time_s = Eigen::VectorXd::LinSpaced(kSamples, 0.0, 30.0);
      const auto run = codegen::ReferenceObserver<double>(observer).run(v, {}, time_s, true);
      worst = std::max(worst, run.x_hat.colwise().norm().maxCoeff());
    }
    EXPECT_LE(worst, result.bounds[kWeightsBound].steady) << "k = " << k;
    EXPECT_GT(worst, result.measured.steady_max) << "control: it is worse than random noise";
  }
}

TEST(ProvenBound, ConstantNoiseReachesTheBoundOfAScalarPlant) {
  BoundTest test;
  test.trajectories = 3;
  test.noise = 0.5;
  for (const double k : {1.0, 4.0}) {
    const BoundResult result =
        exact_result(scalar_plant(), model_of(scalar_plant(), Eigen::VectorXd::Constant(1, -1.0)), k, test, 40.0);
    // T = 1 / (k - 0.1), e = V / k: by hand.
    EXPECT_NEAR(result.measured.offset_max, 0.5 * (k - 0.1) / k, 1e-4) << "the hold's error";
    EXPECT_LE(result.measured.offset_max, result.bounds[kWeightsBound].steady);
    EXPECT_GT(result.measured.offset_max, 0.99 * result.bounds[kWeightsBound].steady)
        << "control: a hundredth less would break";
  }
}

TEST(BrokenBound, FiresOnALinearPlantForAnObserverThatIsNotTheInverseOfT) {
  BoundTest test;
  test.trajectories = 3;
  test.noise = 0.5;
  const LinearPlant plant = scalar_plant();
  const BoundStudy study(plant, model_of(plant, Eigen::VectorXd::Constant(1, -1.0)), simulation_of(plant), test);
  BoundReport report{"test", plant.name(), true, test, 20.0, {study.at(1.0, study.exact_observer(1.0), "exact")}};
  EXPECT_EQ(broken_bound(report), "");
  // An observer whose T* amplifies more than the pseudo-inverse does: its own constant is 5 % larger,
  // the plant's T not.
  codegen::Model beside = study.exact_observer(1.0);
  codegen::inverse_map(beside)->layers[0].weights *= 1.05;
  report.results.push_back(study.at(1.0, beside, "beside"));
  EXPECT_EQ(broken_bound(report), "k = 1");
  report.exact = false;
  EXPECT_EQ(broken_bound(report), "") << "elsewhere it is reported, not a defect";
}

TEST(ProvenBound, FasterEigenvaluesForgetSoonerAndAmplifyMore) {
  BoundTest test;
  test.trajectories = 10;
  test.noise = 0.5;
  const codegen::Model model = model_of(oscillator(), Eigen::Vector2d(-1.0, -1.5));
  const BoundResult slow = exact_result(oscillator(), model, 2.0, test),
                    fast = exact_result(oscillator(), model, 8.0, test);
  EXPECT_LT(*fast.measured.transient_s, 0.5 * *slow.measured.transient_s);
  EXPECT_GT(fast.measured.steady_rms, 2.0 * slow.measured.steady_rms);
  EXPECT_LT(fast.transient_s[kWeightsBound], slow.transient_s[kWeightsBound]);
  EXPECT_GT(fast.bounds[kWeightsBound].steady, slow.bounds[kWeightsBound].steady);
}

/// x'' = -2 zeta x' - x.
LinearPlant second_order(double zeta) {
  Eigen::Matrix2d a;
  a << 0.0, 1.0, -1.0, -2.0 * zeta;
  return {"second_order", channels({"x1", "x2"}), channels({"y"}), a, Eigen::RowVector2d(1.0, 0.0)};
}

TEST(ProvenBound, TheTransientEndsBeforeItsBoundSays) {
  // Undamped, damped, overdamped, and one whose bound is met: a single state that always starts in the same place.
  BoundTest test;
  test.trajectories = 6;
  test.threads = 1;
  const auto expect = [&](const LinearPlant& plant, const Eigen::VectorXd& eigenvalues, double lowest_start,
                          const std::string& which) {
    SimulationConfig simulation = simulation_of(plant, 12.0);
    simulation.initial_low.assign(simulation.initial_low.size(), lowest_start);
    for (const char* hold : {"first_order", "zero_order"}) {
      const BoundStudy study(plant, model_of(plant, eigenvalues, 0, hold), simulation, test);
      for (const double k : {1.0, 2.0, 4.0, 8.0}) {
        const BoundResult result = study.at(k, study.exact_observer(k), "pseudo-inverse");
        ASSERT_TRUE(result.measured.transient_s) << which << ", " << hold << ", k = " << k;
        EXPECT_LE(*result.measured.transient_s, result.transient_s[kWeightsBound])
            << which << ", " << hold << ", k = " << k;
      }
    }
  };
  for (const double start : {-1.0, 1.0}) {
    for (const double zeta : {0.0, 0.1, 0.8, 3.0})
      expect(second_order(zeta), Eigen::Vector3d(-0.9, -1.3, -2.1), start, "zeta = " + std::to_string(zeta));
    expect(scalar_plant(), Eigen::VectorXd::Constant(1, -1.0), start, "scalar");
  }
}

}  // namespace
}  // namespace nlo::trainer
