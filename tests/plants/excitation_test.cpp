// SPDX-License-Identifier: MIT
#include "trainer/plants/excitation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "codegen/base/error.h"
#include "trainer/plants/linear.h"
#include "trainer/plants/registry.h"
#include "trainer/plants/simulate.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;

std::unique_ptr<Plant> named(const std::string& model) {
  PlantConfig config;
  config.model = model;
  return make_plant(config);
}

SimulationConfig sampled(double period_s, double horizon_s) {
  SimulationConfig config;
  config.sample_period_s = period_s;
  config.horizon_s = horizon_s;
  return config;
}

std::string error_of(const Plant& plant, const std::vector<std::string>& expressions, double time_s = 0.0) {
  try {
    const Excitation excitation = parse_excitation(plant, expressions);
    if (excitation) excitation(time_s);
  } catch (const codegen::Error& error) {
    return error.what();
  }
  return "no error";
}

/// x1'' = -x1 + cos 12t from rest: x1 = (cos t - cos 12t) / 143. The largest error of x1 over 2 s.
double error_against_the_closed_form(double h, const Excitation& excitation) {
  const Dataset d = simulate_from(*named("harmonic_oscillator"), sampled(h, 2.0), Eigen::Vector2d::Zero(), excitation);
  const Trajectory& run = d.trajectories[0];
  const Eigen::ArrayXd x1 = (run.time_s.array().cos() - (12.0 * run.time_s.array()).cos()) / 143.0;
  return (run.states.row(0).transpose().array() - x1).abs().maxCoeff();
}

TEST(Excitation, OfALinearPlantGivesItsClosedFormAtFourthOrder) {
  const Excitation u = parse_excitation(*named("harmonic_oscillator"), {"cos(12*t)"});
  const double coarse = error_against_the_closed_form(0.02, u), fine = error_against_the_closed_form(0.01, u);
  EXPECT_LT(coarse, 1e-5);
  EXPECT_NEAR(std::log2(coarse / fine), 4.0, 0.2);

  // Control: the same input held between the samples is of first order.
  const auto held = [](double h) -> Excitation {
    return [h](double t) { return Eigen::VectorXd::Constant(1, std::cos(12.0 * h * std::floor(t / h + 1e-6))); };
  };
  const double held_coarse = error_against_the_closed_form(0.02, held(0.02));
  EXPECT_LT(std::log2(held_coarse / error_against_the_closed_form(0.01, held(0.01))), 2.0);
  EXPECT_GT(held_coarse, 100.0 * coarse);
}

TEST(Excitation, IsRecordedAtTheSamples) {
  const auto plant = named("van_der_pol");
  const Eigen::MatrixXd initial = Eigen::MatrixXd::Random(2, 3);
  const Dataset d = simulate_from(*plant, sampled(0.1, 5.0), initial, parse_excitation(*plant, {"t^2 - 1"}));
  ASSERT_EQ(d.inputs.size(), 1u);
  EXPECT_EQ(d.inputs[0].name, "u");
  for (const Trajectory& run : d.trajectories) {
    ASSERT_EQ(run.inputs.rows(), 1);
    ASSERT_EQ(run.inputs.cols(), run.samples());
    EXPECT_LE((run.inputs.row(0).transpose().array() - run.time_s.array().square() + 1.0).abs().maxCoeff(), 1e-13);
  }
  const Dataset alone = simulate_from(*plant, sampled(0.1, 5.0), initial);
  EXPECT_TRUE(alone.inputs.empty());
  EXPECT_EQ(alone.trajectories[0].inputs.size(), 0);
  EXPECT_NE(alone.trajectories[0].states, d.trajectories[0].states);
}

TEST(Excitation, OfZeroChangesNothing) {
  for (const PlantEntry& entry : plant_registry()) {
    const auto plant = named(std::string(entry.name));
    if (plant->nu() == 0) continue;
    const Eigen::MatrixXd initial = Eigen::MatrixXd::Random(plant->nx(), 2);
    const std::vector<std::string> zero(static_cast<std::size_t>(plant->nu()), "0");
    const Dataset a = simulate_from(*plant, sampled(0.02, 3.0), initial, parse_excitation(*plant, zero));
    const Dataset b = simulate_from(*plant, sampled(0.02, 3.0), initial);
    EXPECT_EQ(a.trajectories[1].states, b.trajectories[1].states) << entry.name;
  }
}

TEST(Excitation, DrivesAPlantByExpressionsAsItDrivesTheBuiltIn) {
  PlantConfig config;
  config.states = {"a", "b"};
  config.derivative = {"b^3", "-a"};
  config.outputs = {"a"};
  config.inputs = {"push"};
  config.input_field = {{"0"}, {"1"}};
  const auto a = make_plant(config), b = named("reverse_duffing");
  const Eigen::Vector2d initial(0.5, -0.5);
  const auto states = [&](const Plant& plant) {
    return simulate_from(plant, sampled(0.02, 10.0), initial, parse_excitation(plant, {"cos(12*t)"}))
        .trajectories[0]
        .states;
  };
  EXPECT_LE((states(*a) - states(*b)).cwiseAbs().maxCoeff(), 1e-12);  // 500 steps of 1e-16, no instability
}

TEST(Excitation, HasOneExpressionForEachInputInOrder) {
  const Eigen::Matrix2d b = Eigen::Matrix2d::Identity();
  const LinearPlant plant("pair", channels({"x1", "x2"}), channels({"y"}), Eigen::Matrix2d::Zero(),
                          Eigen::RowVector2d(1.0, 0.0), channels({"left", "right"}), b);
  const Excitation u = parse_excitation(plant, {"2*t", "sin(pi*t)"});
  EXPECT_EQ(u(0.5), Eigen::VectorXd(Eigen::Vector2d(1.0, 1.0)));
  // Integrators: x = (t^2, (1 - cos(pi t)) / pi).
  const Dataset d = simulate_from(plant, sampled(0.01, 1.0), Eigen::Vector2d::Zero(), u);
  const Eigen::Vector2d end = d.trajectories[0].states.rightCols<1>();
  EXPECT_NEAR(end(0), 1.0, 1e-14);
  EXPECT_NEAR(end(1), 2.0 / 3.141592653589793, 1e-9);  // Simpson's rule: (pi h)^4 / 2880
  EXPECT_THAT(error_of(plant, {"1"}), HasSubstr("plant pair has 2 inputs (left, right), but --input gives 1"));
  EXPECT_THAT(error_of(*named("sine_cosine"), {"1"}), HasSubstr("plant sine_cosine has no input to excite"));
  EXPECT_FALSE(parse_excitation(plant, {}));
}

TEST(Excitation, ErrorsNameTheInputTheExpressionAndThePosition) {
  const auto plant = named("van_der_pol");
  EXPECT_THAT(error_of(*plant, {"cos(12*x1)"}),
              AllOf(HasSubstr("input u \"cos(12*x1)\""), HasSubstr("position 8"), HasSubstr("variables: t")));
  EXPECT_THAT(error_of(*plant, {"cos(12*t"}), HasSubstr("input u \"cos(12*t\""));
  EXPECT_THAT(error_of(*plant, {"u = t"}), HasSubstr("\"=\" has no place"));
  EXPECT_THAT(error_of(*plant, {""}), HasSubstr("the expression is empty"));
  EXPECT_THAT(error_of(*plant, {"sqrt(1 - t)"}, 1.5), HasSubstr("is not a finite number at t = 1.5 s"));
  EXPECT_EQ(error_of(*plant, {"sqrt(1 - t)"}, 0.5), "no error");
}

}  // namespace
}  // namespace nlo::trainer
