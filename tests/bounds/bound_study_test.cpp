// SPDX-License-Identifier: MIT
// Proposition 2 where it can be checked: on linear plants every constant has a closed form and nothing may break the
// bound.
#include "trainer/bounds/bound_study.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <ostream>
#include <string>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/model/hold.h"
#include "codegen/replay/reference_observer.h"
#include "trainer/bounds/bound_text.h"
#include "trainer/bounds/lipschitz.h"
#include "trainer/plants/initial_states.h"
#include "trainer/plants/registry.h"

namespace nlo::trainer {
namespace {

codegen::Model model_of(const Plant& plant, const Eigen::VectorXd& eigenvalues, int pairs = 0,
                        const std::string& hold = "first_order") {
  const Eigen::Index nz = eigenvalues.size();
  codegen::Model model;
  model.name = "test";
  model.outputs = plant.outputs();
  model.states = plant.states();
  model.sample_period_s = 0.02;
  model.hold = *codegen::find_hold(hold);
  codegen::linear_latent(model)->pairs = pairs;
  codegen::linear_latent(model)->eigenvalues = eigenvalues;
  codegen::linear_latent(model)->output_injection = Eigen::MatrixXd::Ones(nz, plant.ny());
  model.initial_latent = Eigen::VectorXd::Zero(nz);
  model.output_min = Eigen::VectorXd::Constant(plant.ny(), -1e3);
  model.output_max = Eigen::VectorXd::Constant(plant.ny(), 1e3);
  model.latent_min = Eigen::VectorXd::Constant(nz, -1e3);
  model.latent_max = Eigen::VectorXd::Constant(nz, 1e3);
  return model;
}

SimulationConfig simulation_of(const Plant& plant, double horizon_s = 20.0) {
  SimulationConfig config;
  config.horizon_s = horizon_s;
  config.sample_period_s = 0.02;
  config.initial_low.assign(static_cast<std::size_t>(plant.nx()), -1.0);
  config.initial_high.assign(static_cast<std::size_t>(plant.nx()), 1.0);
  return config;
}

LinearPlant scalar_plant() {
  return {"scalar", channels({"x"}), channels({"y"}), Eigen::MatrixXd::Constant(1, 1, -0.1),
          Eigen::MatrixXd::Ones(1, 1)};
}

LinearPlant oscillator() {
  Eigen::Matrix2d a;
  a << 0.0, 1.0, -1.0, 0.0;
  return {"oscillator", channels({"x1", "x2"}), channels({"y"}), a, Eigen::RowVector2d(1.0, 0.0)};
}

LinearPlant damped_third_order() {
  Eigen::Matrix3d a;
  a << 0.0, 1.0, 0.0, -4.0, -0.2, 1.0, 0.0, 0.0, -0.3;
  Eigen::MatrixXd c(2, 3);
  c << 1.0, 0.0, 0.0, 0.0, 1.0, 0.5;
  return {"damped", channels({"x1", "x2", "x3"}), channels({"y1", "y2"}), a, c};
}

double constant(const BoundResult& result, const std::string& symbol) {
  for (const BoundConstant& c : result.constants)
    if (c.symbol == symbol) return c.value;
  ADD_FAILURE() << "no constant " << symbol;
  return std::nan("");
}

BoundResult exact_result(const LinearPlant& plant, const codegen::Model& model, double k, const BoundTest& test,
                         double horizon_s = 20.0) {
  const BoundStudy study(plant, model, simulation_of(plant, horizon_s), test);
  return study.at(k, study.exact_observer(k), "pseudo-inverse");
}

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

TEST(BoundStudy, ConstantsOfALinearPlantAreTheClosedForms) {
  constexpr double kRounding = 1e-10;
  const LinearPlant plant = damped_third_order();
  Eigen::VectorXd eigenvalues(5);
  eigenvalues << -1.0, 0.7, -0.8, -2.0, -3.5;
  codegen::Model model = model_of(plant, eigenvalues, 1);
  codegen::linear_latent(model)->output_injection << 1, 0, 0.5, 0, 0, 1, 1, 0, 0, 1;
  const double k = 2.0;
  BoundTest test;
  test.trajectories = 2;
  test.noise = 0.3;
  const BoundResult result = exact_result(plant, model, k, test);

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

  EXPECT_NEAR(constant(result, "L_Tk"), 1.0 / sigma(2), kRounding / sigma(2));
  EXPECT_NEAR(constant(result, "L_Tkx"), sigma(0), kRounding);
  EXPECT_NEAR(constant(result, "l upper"), 1.0 / sigma(2), kRounding / sigma(2)) << "the pseudo-inverse is linear";
  EXPECT_NEAR(constant(result, "k lambda"), -1.6, kRounding);
  EXPECT_EQ(constant(result, "eps"), 0.0);
  double e0 = 0.0;
  for (int corner = 0; corner < 8; ++corner)
    e0 = std::max(e0, (t * Eigen::Vector3d(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1)).norm());
  EXPECT_NEAR(constant(result, "e0"), e0, kRounding);
  EXPECT_NEAR(constant(result, "v_bar"),
              0.3 * std::max((codegen::linear_latent(model)->output_injection * Eigen::Vector2d(1, 1)).norm(),
                             (codegen::linear_latent(model)->output_injection * Eigen::Vector2d(1, -1)).norm()),
              kRounding);
  for (const BoundConstant& c : result.constants) EXPECT_NE(c.evidence, Evidence::kSampled) << c.symbol;
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
        EXPECT_LE(measured.ratio_weights, 1.0) << hold << ", seed " << seed << ", k = " << k;
        EXPECT_GT(measured.ratio_weights, 0.05) << "control: the bound is of the size of what it bounds";
      }
    }
  }
}

TEST(BoundStudy, NoiseMatchedToTheImpulseResponseKeepsToTheBound) {
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
    EXPECT_LE(worst, result.bounds.weights.steady) << "k = " << k;
    EXPECT_GT(worst, result.measured.steady_max) << "control: it is worse than random noise";
  }
}

TEST(BoundStudy, ConstantNoiseReachesTheBoundOfAScalarPlant) {
  BoundTest test;
  test.trajectories = 3;
  test.noise = 0.5;
  for (const double k : {1.0, 4.0}) {
    const BoundResult result =
        exact_result(scalar_plant(), model_of(scalar_plant(), Eigen::VectorXd::Constant(1, -1.0)), k, test, 40.0);
    // T = 1 / (k - 0.1), e = V / k: by hand.
    EXPECT_NEAR(result.measured.offset_max, 0.5 * (k - 0.1) / k, 1e-4) << "the hold's error";
    EXPECT_LE(result.measured.offset_max, result.bounds.weights.steady);
    EXPECT_GT(result.measured.offset_max, 0.99 * result.bounds.weights.steady)
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
  // An observer whose T* amplifies more than the pseudo-inverse does: its own constant is 5 % larger, the plant's T
  // not.
  codegen::Model beside = study.exact_observer(1.0);
  codegen::inverse_map(beside)->layers[0].weights *= 1.05;
  report.results.push_back(study.at(1.0, beside, "beside"));
  EXPECT_EQ(broken_bound(report), "k = 1");
  report.exact = false;
  EXPECT_EQ(broken_bound(report), "") << "elsewhere it is reported, not a defect";
}

TEST(BoundStudy, TheProofsStepThatDividesLTxByKFailsOnTheOscillator) {
  // |t_i| = 1 / sqrt(1 + k^2 lambda_i^2) there, which falls slower than 1 / k.
  BoundTest test;
  test.trajectories = 2;
  const codegen::Model model = model_of(oscillator(), Eigen::Vector2d(-0.5, -1.0));
  for (const double k : {2.0, 4.0, 8.0}) {
    const BoundResult result = exact_result(oscillator(), model, k, test);
    EXPECT_FALSE(result.slope_claim_holds) << "k = " << k;
    EXPECT_GT(k * constant(result, "L_Tkx"), constant(result, "L_Tx"));
  }
  EXPECT_TRUE(exact_result(oscillator(), model, 1.0, test).slope_claim_holds);
}

TEST(BoundStudy, FasterEigenvaluesForgetSoonerAndAmplifyMore) {
  BoundTest test;
  test.trajectories = 10;
  test.noise = 0.5;
  const codegen::Model model = model_of(oscillator(), Eigen::Vector2d(-1.0, -1.5));
  const BoundResult slow = exact_result(oscillator(), model, 2.0, test),
                    fast = exact_result(oscillator(), model, 8.0, test);
  EXPECT_LT(*fast.measured.transient_s, 0.5 * *slow.measured.transient_s);
  EXPECT_GT(fast.measured.steady_rms, 2.0 * slow.measured.steady_rms);
  EXPECT_LT(fast.transient_weights_s, slow.transient_weights_s);
  EXPECT_GT(fast.bounds.weights.steady, slow.bounds.weights.steady);
}

/// x'' = -2 zeta x' - x.
LinearPlant second_order(double zeta) {
  Eigen::Matrix2d a;
  a << 0.0, 1.0, -1.0, -2.0 * zeta;
  return {"second_order", channels({"x1", "x2"}), channels({"y"}), a, Eigen::RowVector2d(1.0, 0.0)};
}

TEST(BoundStudy, TheTransientEndsBeforeItsBoundSays) {
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
        EXPECT_LE(*result.measured.transient_s, result.transient_weights_s) << which << ", " << hold << ", k = " << k;
      }
    }
  };
  for (const double start : {-1.0, 1.0}) {
    for (const double zeta : {0.0, 0.1, 0.8, 3.0})
      expect(second_order(zeta), Eigen::Vector3d(-0.9, -1.3, -2.1), start, "zeta = " + std::to_string(zeta));
    expect(scalar_plant(), Eigen::VectorXd::Constant(1, -1.0), start, "scalar");
  }
}

std::string report_of(const Plant& plant, const codegen::Model& model) {
  BoundTest test;
  test.trajectories = 5;
  test.noise = 0.3;
  test.disturbance = 0.1;
  const BoundStudy study(plant, model, simulation_of(plant), test);
  EXPECT_TRUE(study.exact());
  if (!study.exact()) return "";
  const BoundReport report{"test", "plant", true, test, 20.0, {study.at(2.0, study.exact_observer(2.0), "exact")}};
  return bound_json(report) + bound_csv(report);
}

TEST(BoundStudy, TakesALinearPlantInExpressionsForWhatItIs) {
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
  const codegen::Model model = model_of(*a, Eigen::Vector3d(-0.5, -1.0, -1.5));
  EXPECT_EQ(report_of(*a, model), report_of(*b, model));
}

TEST(BoundStudy, RefusesAPlantWhoseStateCannotBeSeen) {
  const LinearPlant blind("blind", channels({"x1", "x2"}), channels({"y"}),
                          Eigen::Vector2d(-0.1, -0.2).asDiagonal().toDenseMatrix(), Eigen::RowVector2d(1.0, 0.0));
  EXPECT_THROW(BoundStudy(blind, model_of(blind, Eigen::Vector3d(-1, -2, -3)), simulation_of(blind), {}),
               codegen::Error);
}

TEST(BoundStudy, GivesTheSameBytesForAnyNumberOfThreads) {
  std::string first;
  for (const int threads : {1, 3}) {
    BoundTest test;
    test.trajectories = 7;
    test.noise = 0.2;
    test.threads = threads;
    const BoundReport report{
        "test", "oscillator", true,
        test,   20.0,         {exact_result(oscillator(), model_of(oscillator(), Eigen::Vector2d(-1, -2)), 2.0, test)}};
    const std::string text = bound_json(report) + bound_csv(report);
    if (first.empty()) first = text;
    EXPECT_EQ(text, first);
  }
}

TEST(WithInjection, GivesTheSameEstimates) {
  constexpr double kRounding = 1e-12;
  const LinearPlant plant = oscillator();
  codegen::Model model = model_of(plant, Eigen::Vector4d(-0.4, 0.9, -1.0, -2.0), 1);
  BoundTest test;
  test.trajectories = 1;
  model = BoundStudy(plant, model, simulation_of(plant), test).exact_observer(1.0);
  codegen::linear_latent(model)->starts_steady = true;
  codegen::Model fast = model;
  codegen::linear_latent(fast)->output_injection = 3.0 * codegen::linear_latent(model)->output_injection;
  codegen::inverse_map(fast)->features.leftCols(4) /= 3.0;
  const codegen::Model same = with_injection(fast, codegen::linear_latent(model)->output_injection);
  EXPECT_LT((codegen::linear_latent(same)->output_injection - codegen::linear_latent(model)->output_injection).norm(),
            kRounding);
  const Eigen::VectorXd time_s = Eigen::VectorXd::LinSpaced(50, 0.0, 0.98);
  const Eigen::MatrixXd y = time_s.array().sin().transpose() + 0.5;
  const auto before = codegen::ReferenceObserver<double>(fast).run(y, {}, time_s, true),
             after = codegen::ReferenceObserver<double>(same).run(y, {}, time_s, true);
  EXPECT_LT((before.x_hat - after.x_hat).norm(), kRounding);
  EXPECT_GT((before.z - after.z).norm(), 1.0) << "control: in other coordinates";
}

TEST(BoundStudy, SeesThatTIsNotDifferentiableWhereDIsSlowerThanThePlantContracts) {
  // Van der Pol's limit cycle contracts by 1.06 per second: T of slower modes is continuous there, no more.
  PlantConfig config;
  config.model = "van_der_pol";
  const auto plant = make_plant(config);
  BoundTest test;
  test.trajectories = 12;
  const auto slope = [&](double lambda) {
    const codegen::Model model = model_of(*plant, Eigen::Vector3d(lambda, 1.3 * lambda, 1.7 * lambda));
    const LatentSystem system = latent_system(model);
    const SimulationConfig simulation = simulation_of(*plant, 30.0);
    const Eigen::MatrixXd initial = draw_initial_states(simulation, 1, test.trajectories);
    return sampled_map_constants(*plant, system, simulate_disturbed(*plant, simulation, initial, 0.0, 1).set, initial)
        .l_tx;
  };
  EXPECT_TRUE(std::isinf(slope(-0.4)));
  EXPECT_TRUE(std::isfinite(slope(-2.0)));
}

}  // namespace
}  // namespace nlo::trainer
