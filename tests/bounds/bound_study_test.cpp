// SPDX-License-Identifier: MIT
// Proposition 2 where it can be checked: on linear plants every constant has a closed form and nothing may break the
// bound.
#include "trainer/bounds/bound_study.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <string>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/replay/reference_observer.h"
#include "tests/bounds/linear_plants.h"
#include "trainer/bounds/bound_text.h"
#include "trainer/bounds/lipschitz.h"
#include "trainer/plants/initial_states.h"

namespace nlo::trainer {
namespace {

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
