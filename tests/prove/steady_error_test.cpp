// SPDX-License-Identifier: MIT
// The bound of the steady error: its parts on linear plants, where T, J and the worst noise are known, and the whole
// compared with the search that tries to exceed it.
#include "trainer/prove/steady_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <memory>
#include <string>

#include "codegen/model_file/model_file.h"
#include "tests/prove/linear_plants.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/prove/certificate.h"
#include "trainer/prove/forward_map.h"
#include "trainer/prove/forward_spline.h"
#include "trainer/prove/latent_memory.h"
#include "trainer/prove/steady_falsifier.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;

PlantConfig damped_equations() {
  PlantConfig plant;
  plant.states = {"x1", "x2"};
  plant.derivative = {"x2", "-4 * x1 - 0.5 * x2"};
  plant.outputs = {"x1"};
  return plant;
}

LinearPlant damped() {
  Eigen::Matrix2d a;
  a << 0.0, 1.0, -4.0, -0.5;
  return {"damped", channels({"x1", "x2"}), channels({"y"}), a, Eigen::RowVector2d(1.0, 0.0)};
}

StateBox box_of(double radius) {
  return {Eigen::Vector2d::Zero(), Eigen::Vector2d::Constant(radius)};
}

TEST(PlantEnclosure, RatesEncloseThoseOfTheMotion) {
  const PlantEnclosure plant(damped_equations());
  const Eigen::Vector2d x(0.3, -0.7);
  const PlantRanges at = plant.over({x, Eigen::Vector2d::Zero()});
  Eigen::Matrix2d a;
  a << 0.0, 1.0, -4.0, -0.5;
  Eigen::Vector2d motion = x;
  for (std::size_t i = 0; i < PlantRanges::kRates; ++i) {
    EXPECT_NEAR(at.rates[i](0).low, motion(0), 1e-14) << i;
    EXPECT_LE(at.rates[i](0).low, motion(0) + 1e-14);
    motion = a * motion;
  }
}

TEST(PlantEnclosure, ASlopeWithoutABoundIsRefused) {
  PlantConfig plant = damped_equations();
  plant.derivative[1] = "-sqrt(x1)";
  EXPECT_THROW(PlantEnclosure{plant}, codegen::Error);
}

TEST(ForwardSpline, EqualsTheSylvesterSolutionForALinearPlant) {
  const LinearPlant plant = damped();
  const codegen::Model model = model_of(plant, Eigen::Vector3d(-2.0, 3.0, -5.0), 1);
  const LatentSystem system = latent_system(model);
  const PlantEnclosure equations(damped_equations());
  const StateRegion region(box_of(1.0), 4);
  const HoldEffect none(Hold::kFirstOrder, 0.0);
  const Eigen::MatrixXd t = sylvester_map(plant.a(), plant.c(), system), x = region.points(4, 1);
  const ForwardSpline spline(equations, system, region, none, x, t * x);
  const StateBox at{Eigen::Vector2d(0.31, -0.2), Eigen::Vector2d::Constant(0.02)};
  const MapRanges ranges = spline.over(at);
  EXPECT_LT((ranges.at_centre.middle() - t * at.centre).norm(), 1e-9);
  EXPECT_LT((ranges.slopes_at_centre.middle() - t).norm(), 1e-8);
  EXPECT_LT(spline.residual(at).norm(), 1e-7);  // a fit to about 1e-9, whose slopes are less accurate
  EXPECT_LT(ranges.bent.norm(), 1e-9);
}

/// Returns the difference between the step of a mode and the steady response T~ to g, for y = exp(omega t).
double left_over(Hold hold, double dt, const HoldEffect& effect) {
  const std::complex<double> lambda(-1.5, 2.0), omega(0.0, 2.0);
  const std::complex<double> g =
      1.0 + effect.first * omega + effect.second * omega * omega + effect.crossed * lambda * omega;
  const std::complex<double> t = g / (omega - lambda), a = std::exp(lambda * dt), next = std::exp(omega * dt);
  const std::complex<double> phi1 = (a - 1.0) / lambda, phi2 = (phi1 - dt) / (lambda * dt);
  return std::abs(t * next - a * t - (hold == Hold::kZeroOrder ? phi1 : phi1 - phi2 + phi2 * next));
}

TEST(HoldEffect, TheRemainderOfAStepIsWithinItsBoundAndOfFourthOrder) {
  for (const Hold hold : {Hold::kZeroOrder, Hold::kFirstOrder}) {
    double before = 0.0;
    for (const double dt : {0.2, 0.1, 0.05}) {
      const double off = left_over(hold, dt, HoldEffect(hold, dt));
      EXPECT_LE(off, HoldEffect::left_over(hold, dt, 2.5, {2.0, 4.0, 8.0}, {}));
      if (before > 0.0) {
        EXPECT_GT(std::log2(before / off), 3.7);  // 5 with linear interpolation between samples
      }
      before = off;
    }
  }
}

TEST(HoldEffect, ControlWithoutItsSecondOrderTheBoundDoesNotHold) {
  for (const Hold hold : {Hold::kZeroOrder, Hold::kFirstOrder}) {
    HoldEffect effect(hold, 0.02);
    effect.second = 0.0;
    EXPECT_GT(left_over(hold, 0.02, effect), HoldEffect::left_over(hold, 0.02, 2.5, {2.0, 4.0, 8.0}, {}));
  }
}

TEST(LatentMemory, LargestEffectOfNoiseIsReachedByTheWorstSigns) {
  const codegen::Model model = model_of(damped(), Eigen::Vector3d(-2.0, 3.0, -5.0), 1);
  const LatentMemory memory(model);
  const Eigen::RowVector3d row(1.0, -0.5, 2.0);
  Eigen::VectorXd z = Eigen::VectorXd::Zero(3);
  const double v = 0.1, d = 0.01;
  for (Eigen::Index k = memory.steps - 1; k >= 0; --k) {  // the worst sign of each sample
    const auto sign = [&](double effect) { return effect < 0.0 ? -1.0 : 1.0; };
    const double now = v * sign((row * memory.noise.col(k))(0)), later = v * sign((row * memory.noise.col(k + 1))(0));
    const Eigen::VectorXd push = (row * memory.powers.middleCols(k * 3, 3)).transpose().unaryExpr(sign) * d;
    z = (memory.a * z + memory.b0 * later + memory.b1 * now + push).eval();
  }
  const double largest = memory.largest(row, Eigen::VectorXd::Constant(1, v), Eigen::VectorXd::Constant(3, d))(0);
  EXPECT_GE(largest, (row * z)(0) * (1.0 - 1e-12));
  EXPECT_LT(largest, (row * z)(0) * 1.001);  // the effect of the first sample and the cut-off tail
}

/// The shipped observer of Van der Pol.
struct Shipped {
  std::string path = std::string(NLO_SOURCE_DIR) + "/examples/models/van_der_pol.json";
  codegen::Model model = codegen::read_model(path);
  Experiment experiment = experiment_of(model, path);
  std::unique_ptr<Plant> plant = make_plant(*experiment.plant);
  SteadyQuestion question{0.1, 0.0, 12000};
  SteadyStates states = steady_states(model, *plant, experiment.simulation, 0.0, 40, 1);
  StateRegion region = StateRegion::around(states.visited, 1500);

  SteadyFound found() const {
    Eigen::MatrixXd starts(2, 20);
    for (Eigen::Index i = 0; i < starts.cols(); ++i) starts.col(i) = states.x.col(i * states.x.cols() / starts.cols());
    return largest_steady_error(model, *plant, region, states, starts, question);
  }
};

TEST(SteadyError, TheBoundIsAboveTheLargestFoundErrorAndWithinThreeTimesOfIt) {
  const Shipped shipped;
  const SteadyError proof =
      steady_error(shipped.model, *shipped.experiment.plant, shipped.region, shipped.states, shipped.question);
  const SteadyFound found = shipped.found();
  EXPECT_GT(found.runs, 5);
  for (Eigen::Index i = 0; i < 2; ++i) {
    EXPECT_GE(proof.bound(i), found.error(i)) << i;
    EXPECT_LE(proof.bound(i), 3.0 * found.error(i)) << i;
    EXPECT_GE(proof.approximation(i), found.approximation(i)) << i;
    EXPECT_LE(proof.approximation(i), 3.0 * found.approximation(i)) << i;
  }
}

TEST(SteadyError, ControlTheSearchExceedsABoundForHalfTheNoise) {
  Shipped shipped;
  shipped.question.noise = 0.05;
  const SteadyError proof =
      steady_error(shipped.model, *shipped.experiment.plant, shipped.region, shipped.states, shipped.question);
  shipped.question.noise = 0.1;
  EXPECT_GT(shipped.found().error.maxCoeff(), proof.bound.maxCoeff());
}

TEST(SteadyError, BoundGrowsWithADisturbance) {
  Shipped shipped;
  shipped.question = {0.0, 0.02, 4000};
  shipped.states = steady_states(shipped.model, *shipped.plant, shipped.experiment.simulation, 0.02, 40, 1);
  shipped.region = StateRegion::around(shipped.states.visited, 1500);
  const SteadyError proof =
      steady_error(shipped.model, *shipped.experiment.plant, shipped.region, shipped.states, shipped.question);
  const SteadyFound found = shipped.found();
  for (Eigen::Index i = 0; i < 2; ++i) EXPECT_GE(proof.bound(i), found.error(i)) << i;
  EXPECT_GT(proof.bound(0), proof.approximation(0));
}

TEST(SteadyError, RefusesNoiseBeyondTheRangeOfTheObserver) {
  Shipped shipped;
  shipped.question.noise = 50.0;
  try {
    (void)steady_error(shipped.model, *shipped.experiment.plant, shipped.region, shipped.states, shipped.question);
    FAIL() << "not refused";
  } catch (const codegen::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("output y reaches"));
    EXPECT_THAT(error.what(), HasSubstr("less --noise"));
  }
}

TEST(StateRegion, ContainsItsPointsAndItsCoarserCellsContainIt) {
  const Shipped shipped;
  const StateRegion coarse = shipped.region.coarser(100);
  EXPECT_LE(coarse.places().size(), 100U);
  for (Eigen::Index b = 0; b < shipped.states.x.cols(); b += 97) {
    EXPECT_TRUE(shipped.region.contains(shipped.states.x.col(b)));
    EXPECT_TRUE(coarse.contains(shipped.states.x.col(b)));
  }
  EXPECT_FALSE(shipped.region.contains(Eigen::Vector2d::Zero())) << "inside of the limit cycle";
}

TEST(CertifySteadyError, SaysWhyAModelWithoutAPlantHasNoBound) {
  const Shipped shipped;
  const CertificateRows rows = steady_rows(shipped.model, {});
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_TRUE(std::isnan(rows[0].bound));
  EXPECT_THAT(rows[0].note, HasSubstr("needs the plant's equations"));
}

}  // namespace
}  // namespace nlo::trainer
