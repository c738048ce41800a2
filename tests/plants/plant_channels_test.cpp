// SPDX-License-Identifier: MIT
// A pendulum given by expressions that makes full turns: its angle in each encoding that logs may have.
#include "trainer/plants/plant_channels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/thrown_message.h"
#include "trainer/experiments/training_sets.h"
#include "trainer/plants/lead_in.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/simulate.h"

namespace nlo::trainer {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kRounding = 1e-12;  // rounding of angles of some 30 rad in double

/// `angle`: h(x), an angle in the unit of `turn`.
PlantConfig pendulum(const std::string& angle = "theta", double turn = kTurn) {
  PlantConfig config;
  config.states = {"theta", "omega"};
  config.derivative = {"omega", "-9.81*sin(theta)"};
  config.output_names = {"angle"};
  config.outputs = {angle};
  config.state_wraps = {kTurn, 0.0};
  config.output_wraps = {turn};
  return config;
}

/// Two runs of 4 s: one makes full turns, the other swings.
Dataset swung(const PlantConfig& config) {
  SimulationConfig simulation;
  simulation.horizon_s = 4.0;
  simulation.sample_period_s = 0.01;
  Eigen::MatrixXd initial(2, 2);
  initial << 0.0, 0.5, -9.0, 0.0;
  return simulate_from(*make_plant(config), simulation, initial);
}

std::vector<std::string> names_of(const std::vector<Channel>& channels) {
  std::vector<std::string> names;
  for (const Channel& channel : channels) names.push_back(channel.name);
  return names;
}

std::string error_of(const PlantConfig& config) {
  return thrown_message([&] { PlantChannels(config, *make_plant(config)); });
}

TEST(PlantAngles, AreUnwrappedAlongARunLikeAnglesOfLogs) {
  for (const auto& [angle, turn] : {std::pair{"theta", kTurn},
                                    {"atan2(sin(theta), cos(theta))", kTurn},
                                    {"180/pi*atan2(sin(theta), cos(theta))", 360.0}}) {
    SCOPED_TRACE(angle);
    const Dataset data = swung(pendulum(angle, turn));
    EXPECT_EQ(data.outputs[0].wrap, turn);
    EXPECT_EQ(data.states[0].wrap, kTurn);
    for (const Trajectory& run : data.trajectories)
      EXPECT_LE((run.outputs.row(0) * kTurn / turn - run.states.row(0)).cwiseAbs().maxCoeff(), kRounding);
    EXPECT_LT(data.trajectories[0].states(0, 400), -3.0 * kTurn) << "control: it makes full turns";
  }
}

TEST(PlantAngles, AreUnwrappedAcrossALeadIn) {
  const PlantConfig config = pendulum("atan2(sin(theta), cos(theta))");
  Dataset data = swung(config);
  const Eigen::Index before = data.trajectories[0].samples();
  add_lead_in(*make_plant(config), 1.0, 50.0, data);
  const Trajectory& run = data.trajectories[0];
  ASSERT_EQ(run.samples(), before + 100);
  EXPECT_GT(run.states(0, 0), 0.5 * kTurn) << "control: its past is more than half a turn away";
  const Eigen::RowVectorXd turns = (run.outputs.row(0) - run.states.row(0)) / kTurn;
  EXPECT_LE((turns.array() - std::round(turns(0))).abs().maxCoeff(), kRounding);
}

TEST(PlantChannels, AreThoseOfThePlantByDefault) {
  const PlantConfig config = pendulum();
  const PlantChannels channels(config, *make_plant(config));
  EXPECT_TRUE(channels.plain());
  Dataset data = swung(config);
  const Eigen::MatrixXd states = data.trajectories[0].states;
  channels.apply(data);
  EXPECT_EQ(data.trajectories[0].states, states);
  EXPECT_EQ(data.sensors(), 1u);
}

TEST(PlantChannels, GiveAnglesAsSineAndCosine) {
  PlantConfig config = pendulum("180/pi*theta", 360.0);
  config.state_encodings = {Encoding::kSincos, Encoding::kUnwrap};
  config.output_encodings = {Encoding::kSincos};
  const auto plant = make_plant(config);
  const PlantChannels channels(config, *plant);
  Dataset data = swung(config);
  const Dataset own = data;
  for (Trajectory& run : data.trajectories) run.derivatives = plant->derivative(run.states);
  channels.apply(data);
  EXPECT_THAT(names_of(data.states), ElementsAre("theta_sin", "theta_cos", "omega"));
  EXPECT_THAT(names_of(data.outputs), ElementsAre("angle_sin", "angle_cos"));
  ASSERT_EQ(data.output_angles.size(), 1u);
  EXPECT_EQ(data.output_angles[0].sine, 0);
  EXPECT_EQ(data.output_angles[0].wrap, 360.0);
  EXPECT_EQ(data.sensors(), 1u);
  EXPECT_FALSE(channels.plain());
  EXPECT_TRUE(channels.all_states());
  const Trajectory& run = data.trajectories[0];
  const Eigen::RowVectorXd theta = own.trajectories[0].states.row(0), omega = own.trajectories[0].states.row(1);
  const Eigen::RowVectorXd sine = theta.array().sin(), cosine = theta.array().cos();
  const auto expect_row = [](const Eigen::RowVectorXd& channel, const Eigen::RowVectorXd& expected) {
    EXPECT_LE((channel - expected).cwiseAbs().maxCoeff(), kRounding);
  };
  expect_row(run.states.row(0), sine);
  expect_row(run.states.row(1), cosine);
  expect_row(run.states.row(2), omega);
  expect_row(run.outputs.row(0), sine);
  expect_row(run.outputs.row(1), cosine);
  expect_row(run.derivatives.row(0), cosine.cwiseProduct(omega));
  expect_row(run.derivatives.row(1), -sine.cwiseProduct(omega));
  // The inverse: the angle itself, within half a turn.
  const Eigen::RowVectorXd degrees = channels.plant_outputs(run.outputs);
  EXPECT_LE(degrees.cwiseAbs().maxCoeff(), 180.0);
  EXPECT_LE((degrees * std::numbers::pi / 180.0 - theta)
                .unaryExpr([](double difference) { return std::remainder(difference, kTurn); })
                .cwiseAbs()
                .maxCoeff(),
            kRounding);
}

TEST(PlantChannels, AreTheEstimatedStatesInTheirOrder) {
  PlantConfig config = pendulum();
  config.estimated = {"omega"};
  const PlantChannels rate(config, *make_plant(config));
  EXPECT_THAT(names_of(rate.states()), ElementsAre("omega"));
  EXPECT_FALSE(rate.plain());
  EXPECT_FALSE(rate.all_states());
  Dataset data = swung(config);
  const Eigen::MatrixXd own = data.trajectories[1].states;
  rate.apply(data);
  EXPECT_EQ(data.trajectories[1].states, own.row(1));
  EXPECT_EQ(data.trajectories[1].unestimated, own.row(0)) << "a prior also steps this state";
  EXPECT_EQ(data.trajectories[1].from(2).unestimated, own.row(0).rightCols(own.cols() - 2));
  config.estimated = {"omega", "theta"};
  const PlantChannels swapped(config, *make_plant(config));
  EXPECT_FALSE(swapped.plain());
  EXPECT_TRUE(swapped.all_states());
  EXPECT_EQ(swapped.states(own).row(0), own.row(1));
}

TEST(PlantAngles, MayNotMakeFullTurnsIfTheyAreEstimatedUnwrapped) {
  Experiment experiment;
  experiment.plant = pendulum();
  experiment.plant->output_encodings = {Encoding::kSincos};
  experiment.simulation.horizon_s = 4.0;
  experiment.simulation.initial_distribution = InitialDistribution::kList;
  experiment.simulation.initial_states = {{0.5, 0.0}};
  EXPECT_NO_THROW(simulate_training_sets(experiment)) << "control: it may swing";
  experiment.simulation.initial_states = {{0.0, 9.0}};
  EXPECT_THAT(thrown_message([&] { simulate_training_sets(experiment); }),
              HasSubstr("the state theta makes whole turns"));
  experiment.plant->state_encodings = {Encoding::kSincos, Encoding::kUnwrap};
  EXPECT_NO_THROW(simulate_training_sets(experiment));
}

TEST(PlantChannels, NameTheKeyThatIsWrong) {
  const auto broken = [](auto change) {
    PlantConfig config = pendulum();
    change(config);
    return error_of(config);
  };
  EXPECT_THAT(broken([](PlantConfig& c) { c.state_wraps = {1.0}; }), HasSubstr("state_wraps has 1 entries"));
  EXPECT_THAT(broken([](PlantConfig& c) {
                c.output_encodings = {Encoding::kSincos, Encoding::kUnwrap};
              }),
              HasSubstr("output_encodings has 2 entries"));
  EXPECT_THAT(broken([](PlantConfig& c) {
                c.state_encodings = {Encoding::kUnwrap, Encoding::kSincos};
              }),
              HasSubstr("state_encodings[1] is \"sincos\", but omega is not an angle"));
  EXPECT_THAT(broken([](PlantConfig& c) { c.estimated = {"omga"}; }), HasSubstr("did you mean \"omega\"?"));
  EXPECT_THAT(broken([](PlantConfig& c) { c.estimated = {"omega", "omega"}; }), HasSubstr("\"omega\" twice"));
  EXPECT_THAT(broken([](PlantConfig& c) {
                c.states = {"theta", "theta_sin"};
                c.derivative = {"theta_sin", "-theta"};
                c.state_encodings = {Encoding::kSincos, Encoding::kUnwrap};
              }),
              HasSubstr("two channels of the name \"theta_sin\""));
  PlantConfig builtin;
  builtin.model = "van_der_pol";
  builtin.output_wraps = {kTurn};
  EXPECT_THAT(error_of(builtin), HasSubstr("output_wraps is for a plant given by equations"));
}

}  // namespace
}  // namespace nlo::trainer
