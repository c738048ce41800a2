// SPDX-License-Identifier: MIT
// Proposition 2 on linear plants, where it can be checked: each constant has a closed form, and no error of an observer
// with the exact inverse of T exceeds the bound.
#include "trainer/prove/robustness.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <ostream>
#include <string>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/replay/reference_observer.h"
#include "tests/prove/linear_plants.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/judge/evaluation/disturbed_runs.h"
#include "trainer/plants/initial_states.h"

namespace nlo::trainer {
namespace {

TEST(Bound19, IsTheFormulaOfThePaper) {
  const Proposition2 p{2, 3, -0.5, 1.5, 0.8};
  const ErrorBound bound = bound_19(p, 2.0, 0.1, 0.3);
  const double factor = 8.0 * std::sqrt(2.0) * 1.5;
  EXPECT_NEAR(bound.at(0.7, 2.0), factor * std::exp(-0.7) * 2.0 + factor / 1.0 * (0.8 / 2.0 * 0.1 + 0.3), 1e-12);
}

TEST(ErrorBound, TransientEndsWhenTheWholeBoundFallsBelowTheLevel) {
  const ErrorBound bound{3.0, -0.5, 0.2};
  const double t = bound.transient_s(2.0, 0.3);
  EXPECT_NEAR(bound.at(t, 2.0), 0.3, 1e-12);
  EXPECT_EQ(bound.transient_s(0.01, 0.3), 0.0);
  EXPECT_TRUE(std::isinf(bound.transient_s(2.0, 0.2))) << "it settles at this level and never falls below";
}

TEST(InjectedBound, IsReachedAtTheWorstCorner) {
  Eigen::Matrix2d f;
  f << 1.0, -2.0, 0.5, 1.0;
  EXPECT_NEAR(injected_bound(f, Eigen::Vector2d(1.0, 1.0)), std::hypot(3.0, 0.5), 1e-12);  // at (1, -1)
}

TEST(Robustness, HasTheClosedFormConstantsOfALinearPlant) {
  constexpr double kClosedForm = 1e-10;
  const LinearPlant plant = damped_third_order();
  Eigen::VectorXd eigenvalues(5);
  eigenvalues << -1.0, 0.7, -0.8, -2.0, -3.5;
  codegen::Model model = model_of(plant, eigenvalues, 1);
  codegen::linear_latent(model)->output_injection << 1, 0, 0.5, 0, 0, 1, 1, 0, 0, 1;
  const double k = 2.0;
  RobustnessQuestion question;
  question.trajectories = 2;
  question.noise = 0.3;
  const Robustness result = exact_result(plant, model, k, question);

  // T A - D T = F C by Kronecker products: (A' x I - I x D) vec T = vec F C.
  Eigen::MatrixXd d = Eigen::MatrixXd::Zero(5, 5);
  d.topLeftCorner(2, 2) << -1.0, -0.7, 0.7, -1.0;
  d.diagonal().tail(3) = eigenvalues.tail(3);
  d *= k;
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(15, 15);
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = 0; j < 3; ++j)
      system.block(5 * i, 5 * j, 5, 5) = plant.a()(j, i) * Eigen::MatrixXd::Identity(5, 5) -
                                         (i == j ? d : Eigen::MatrixXd(Eigen::MatrixXd::Zero(5, 5)));
  const Eigen::MatrixXd fc = codegen::linear_latent(model)->output_injection * plant.c();
  const Eigen::VectorXd solved = system.fullPivLu().solve(Eigen::VectorXd(fc.reshaped()));
  const Eigen::MatrixXd t = solved.reshaped(5, 3);
  const Eigen::VectorXd sigma = Eigen::JacobiSVD<Eigen::MatrixXd>(t).singularValues();

  EXPECT_TRUE(result.map.exact);
  EXPECT_NEAR(result.map.l_t, 1.0 / sigma(2), kClosedForm / sigma(2));
  EXPECT_NEAR(result.map.l_tx, sigma(0), kClosedForm);
  EXPECT_NEAR(result.bound.gain, 1.0 / sigma(2), kClosedForm / sigma(2)) << "the pseudo-inverse is linear";
  EXPECT_NEAR(result.bound.rate, -1.6, kClosedForm);
  EXPECT_NEAR(result.approximation, 0.0, kClosedForm);
  double e0 = 0.0;
  for (int corner = 0; corner < 8; ++corner)
    e0 = std::max(e0, (t * Eigen::Vector3d(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1)).norm());
  EXPECT_NEAR(result.start, e0, kClosedForm);
}

TEST(Robustness, RecognisesALinearPlantInExpressions) {
  PlantConfig built_in;
  built_in.model = "harmonic_oscillator";
  built_in.parameters = {{"omega", 2.0}};
  PlantConfig written;
  written.states = {"x1", "x2"};
  written.derivative = {"x2", "-omega^2 * x1"};
  written.output_names = {"y"};
  written.outputs = {"x1"};
  written.parameters = {{"omega", 2.0}};
  const auto a = make_plant(built_in), b = make_plant(written);
  const codegen::Model model =
      exact_observer(dynamic_cast<const LinearPlant&>(*a), model_of(*a, Eigen::Vector3d(-0.5, -1.0, -1.5)));
  RobustnessQuestion question;
  question.trajectories = 5;
  question.noise = 0.3;
  question.disturbance = 0.1;
  const Robustness first = robustness(*a, model, simulation_of(*a), question),
                   second = robustness(*b, model, simulation_of(*b), question);
  EXPECT_TRUE(first.map.exact && second.map.exact);
  EXPECT_EQ(first.bound.steady, second.bound.steady);
  EXPECT_EQ(first.steady_found, second.steady_found);
}

TEST(Robustness, RefusesAnUnobservablePlant) {
  const LinearPlant blind("blind", channels({"x1", "x2"}), channels({"y"}),
                          Eigen::Vector2d(-0.1, -0.2).asDiagonal().toDenseMatrix(), Eigen::RowVector2d(1.0, 0.0));
  EXPECT_THROW(robustness(blind, model_of(blind, Eigen::Vector3d(-1, -2, -3)), simulation_of(blind), {}),
               codegen::Error);
}

TEST(Robustness, IsTheSameForAnyNumberOfThreads) {
  RobustnessQuestion question;
  question.trajectories = 7;
  question.noise = 0.2;
  const codegen::Model model = model_of(oscillator(), Eigen::Vector2d(-1, -2));
  const Robustness one = exact_result(oscillator(), model, 2.0, question);
  question.threads = 3;
  const Robustness three = exact_result(oscillator(), model, 2.0, question);
  EXPECT_EQ(one.steady_found, three.steady_found);
  EXPECT_EQ(one.ratio_found, three.ratio_found);
  EXPECT_EQ(one.transient_s, three.transient_s);
}

TEST(Robustness, DetectsThatTIsNotDifferentiableIfDIsSlowerThanThePlantContracts) {
  // The limit cycle of Van der Pol contracts by 1.06 per second; for slower modes T is only continuous there.
  PlantConfig config;
  config.model = "van_der_pol";
  const auto plant = make_plant(config);
  const auto slope = [&](double lambda) {
    const codegen::Model model = model_of(*plant, Eigen::Vector3d(lambda, 1.3 * lambda, 1.7 * lambda));
    const SimulationConfig simulation = simulation_of(*plant, 30.0);
    const Eigen::MatrixXd initial = draw_initial_states(simulation, 1, 12);
    return sampled_map_constants(*plant, latent_system(model),
                                 simulate_disturbed(*plant, simulation, initial, 0.0, 1).set, initial)
        .l_tx;
  };
  EXPECT_TRUE(std::isinf(slope(-0.4)));
  EXPECT_TRUE(std::isfinite(slope(-2.0)));
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

TEST_P(LinearPlants, NoErrorExceedsTheBound) {
  const LinearPlant plant = GetParam().plant();
  const Eigen::VectorXd eigenvalues =
      Eigen::VectorXd::Map(GetParam().eigenvalues.data(), static_cast<Eigen::Index>(GetParam().eigenvalues.size()));
  for (const char* hold : {"first_order", "zero_order"}) {
    codegen::Model model = model_of(plant, eigenvalues, GetParam().pairs, hold);
    if (plant.ny() == 2) codegen::linear_latent(model)->output_injection << 1, 0, 0, 1, 1, 0, 0, 1;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      RobustnessQuestion question;
      question.trajectories = 6;
      question.seed = seed;
      question.noise = seed == 4 ? 0.0 : 0.5;
      question.disturbance = seed == 2 ? 0.0 : 0.2;
      for (const double k : {1.0, 3.0, 8.0}) {
        const Robustness result = exact_result(plant, model, k, question);
        EXPECT_LE(result.ratio_found, 1.0) << hold << ", seed " << seed << ", k = " << k;
        EXPECT_GT(result.ratio_found, 0.05) << "control: the bound is not far above the error";
      }
    }
  }
}

TEST(Robustness, WorstNoiseForTheImpulseResponseStaysWithinTheBound) {
  // The noise with |v| <= V that drives one component of x_hat - x the furthest: the sign of its impulse response,
  // reversed in time. Random noise never comes close.
  const LinearPlant plant = oscillator();
  const codegen::Model model = model_of(plant, Eigen::Vector3d(-0.5, -1.0, -1.5));
  RobustnessQuestion question;
  question.trajectories = 4;
  question.noise = 0.5;
  for (const double k : {1.0, 4.0}) {
    const codegen::Model observer = exact_observer(plant, model, k);
    const Robustness result = robustness(plant, observer, simulation_of(plant, 30.0), question);
    const Eigen::MatrixXd& inverse = codegen::inverse_map(observer)->layers[0].weights;
    constexpr Eigen::Index kSamples = 1501;
    // With the plant at rest, the estimate is the error.
    const Eigen::VectorXd time_s = Eigen::VectorXd::LinSpaced(kSamples, 0.0, 30.0);
    const auto error_with = [&](const Eigen::MatrixXd& v) {
      const auto run = codegen::ReferenceObserver<double>(observer).run(v, {}, time_s, true);
      return Eigen::VectorXd(run.x_hat.colwise().norm());
    };
    double worst = 0.0;
    for (double angle = 0.0; angle < 3.14; angle += 0.2) {
      const Eigen::RowVectorXd component = Eigen::RowVector2d(std::cos(angle), std::sin(angle)) * inverse;
      Eigen::MatrixXd v(1, kSamples);
      for (Eigen::Index n = 0; n < kSamples; ++n) {
        const double ago_s = 0.02 * static_cast<double>(kSamples - 1 - n);
        const Eigen::VectorXd impulse = (codegen::linear_latent(observer)->eigenvalues * ago_s).array().exp() *
                                        codegen::linear_latent(observer)->output_injection.col(0).array();
        v(0, n) = component * impulse >= 0.0 ? question.noise : -question.noise;
      }
      worst = std::max(worst, error_with(v).maxCoeff());
    }
    EXPECT_LE(worst, result.bound.steady) << "k = " << k;
    double random = 0.0;
    for (std::uint64_t run = 0; run < 4; ++run) {
      MeasurementNoise noise({NoiseKind::kUniform, question.noise}, 1, run);
      random = std::max(random, error_with(noise.on(Eigen::MatrixXd::Zero(1, kSamples))).tail(kSamples / 2).maxCoeff());
    }
    EXPECT_GT(worst, random) << "control: its error exceeds that of random noise";
  }
}

TEST(Robustness, ConstantNoiseReachesTheBoundOfAScalarPlant) {
  RobustnessQuestion question;
  question.trajectories = 3;
  question.noise = 0.5;
  for (const double k : {1.0, 4.0}) {
    const Robustness result =
        exact_result(scalar_plant(), model_of(scalar_plant(), Eigen::VectorXd::Constant(1, -1.0)), k, question, 40.0);
    // By hand: T = 1 / (k - 0.1), e = V / k.
    EXPECT_NEAR(result.steady_found, 0.5 * (k - 0.1) / k, 1e-4) << "error of the hold";
    EXPECT_LE(result.steady_found, result.bound.steady);
    EXPECT_GT(result.steady_found, 0.99 * result.bound.steady) << "control: a bound smaller by 1 % would be broken";
  }
}

TEST(Robustness, BoundIncludesTheApproximationErrorOfTStar) {
  RobustnessQuestion question;
  question.trajectories = 3;
  question.noise = 0.5;
  const LinearPlant plant = scalar_plant();
  codegen::Model beside = exact_observer(plant, model_of(plant, Eigen::VectorXd::Constant(1, -1.0)));
  codegen::inverse_map(beside)->layers[0].weights *= 1.05;
  const Robustness result = robustness(plant, beside, simulation_of(plant), question);
  EXPECT_GT(result.approximation, 0.04) << "5 % of a state that is at most 1";
  EXPECT_LE(result.ratio_found, 1.0);
}

TEST(Robustness, FasterEigenvaluesForgetSoonerAndAmplifyNoiseMore) {
  RobustnessQuestion question;
  question.trajectories = 10;
  question.noise = 0.5;
  const codegen::Model model = model_of(oscillator(), Eigen::Vector2d(-1.0, -1.5));
  const Robustness slow = exact_result(oscillator(), model, 2.0, question),
                   fast = exact_result(oscillator(), model, 8.0, question);
  EXPECT_LT(*fast.transient_s, 0.5 * *slow.transient_s);
  EXPECT_GT(fast.steady_found, 1.5 * slow.steady_found);
  EXPECT_LT(fast.quiet.transient_s(fast.start, fast.transient_level),
            slow.quiet.transient_s(slow.start, slow.transient_level));
  EXPECT_GT(fast.bound.steady, slow.bound.steady);
}

/// x'' = -2 zeta x' - x.
LinearPlant second_order(double zeta) {
  Eigen::Matrix2d a;
  a << 0.0, 1.0, -1.0, -2.0 * zeta;
  return {"second_order", channels({"x1", "x2"}), channels({"y"}), a, Eigen::RowVector2d(1.0, 0.0)};
}

TEST(Robustness, TransientEndsBeforeItsBound) {
  // Undamped, damped, overdamped, and a case that reaches its bound: a single state that always starts at the same
  // place.
  RobustnessQuestion question;
  question.trajectories = 6;
  const auto expect = [&](const LinearPlant& plant, const Eigen::VectorXd& eigenvalues, double lowest_start,
                          const std::string& which) {
    SimulationConfig simulation = simulation_of(plant, 12.0);
    simulation.initial_low.assign(simulation.initial_low.size(), lowest_start);
    for (const char* hold : {"first_order", "zero_order"})
      for (const double k : {1.0, 2.0, 4.0, 8.0}) {
        const Robustness result =
            robustness(plant, exact_observer(plant, model_of(plant, eigenvalues, 0, hold), k), simulation, question);
        ASSERT_TRUE(result.transient_s) << which << ", " << hold << ", k = " << k;
        EXPECT_LE(*result.transient_s, result.quiet.transient_s(result.start, result.transient_level))
            << which << ", " << hold << ", k = " << k;
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
