// SPDX-License-Identifier: MIT
#include "trainer/data/log_schema.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/data/testing.h"

namespace nlo::trainer {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

LogConfig with_columns(std::vector<ColumnConfig> columns) {
  LogConfig config;
  config.columns = std::move(columns);
  return config;
}
std::string error_in(std::vector<ColumnConfig> columns) {
  return error_of([&] { resolve_columns(with_columns(std::move(columns))); });
}

const ColumnConfig kTime = column("t", ColumnRole::kTime, {.column = "time"});
const ColumnConfig kAngle = column("theta", ColumnRole::kOutput, {.unit = "rad", .wrap = kTurn});
const ColumnConfig kVelocity = column("omega", ColumnRole::kState, {.unit = "rad/s", .derivative_of = "theta"});

TEST(LogSchema, MakesChannelsOfColumnsInTheirOrder) {
  const LogSchema schema = resolve_columns(
      with_columns({kVelocity, kTime, kAngle, column("x", ColumnRole::kState, {.column = "pos", .unit = "m"}),
                    column("u", ColumnRole::kInput, {.column = "torque"}), column("id", ColumnRole::kIgnored)}));
  EXPECT_EQ(schema.time_heading, "time");
  ASSERT_EQ(schema.output_channels.size(), 1u);
  EXPECT_EQ(schema.output_channels[0].name, "theta");
  EXPECT_EQ(schema.output_channels[0].unit, "rad");
  EXPECT_EQ(schema.output_channels[0].wrap, kTurn);
  ASSERT_EQ(schema.state_channels.size(), 2u);
  EXPECT_EQ(schema.state_channels[0].name, "omega");
  EXPECT_EQ(schema.state_channels[0].wrap, 0.0);  // a velocity does not wrap
  EXPECT_EQ(schema.states[0].heading, "theta");
  EXPECT_EQ(schema.states[0].wrap, kTurn);  // but what it comes from does
  EXPECT_EQ(schema.states[1].heading, "pos");
  EXPECT_EQ(schema.inputs.size(), 1u);
}

TEST(LogSchema, AMirrorKeepsCosinesAndColumnsThatAreNotOdd) {
  ColumnConfig angle = kAngle, speed = column("v", ColumnRole::kState, {.unit = "m/s"});
  angle.encoding = Encoding::kSincos;
  speed.odd = false;
  const LogSchema schema = resolve_columns(with_columns({kTime, angle, kVelocity, speed}));
  EXPECT_EQ(schema.mirror.outputs, (std::vector<double>{-1.0, 1.0}));
  EXPECT_EQ(schema.mirror.states, (std::vector<double>{-1.0, 1.0}));
}

TEST(LogSchema, SplitsAnAngleIntoSineAndCosine) {
  ColumnConfig angle = kAngle;
  angle.encoding = Encoding::kSincos;
  const LogSchema schema = resolve_columns(
      with_columns({kTime, angle, kVelocity,
                    column("theta_true", ColumnRole::kState,
                           {.column = "theta", .unit = "rad", .wrap = kTurn, .encoding = Encoding::kSincos})}));
  ASSERT_EQ(schema.output_channels.size(), 2u);
  EXPECT_EQ(schema.output_channels[0].name, "theta_sin");
  EXPECT_EQ(schema.output_channels[1].name, "theta_cos");
  EXPECT_EQ(schema.output_channels[1].wrap, 0.0);
  ASSERT_EQ(schema.angle_pairs.size(), 1u);
  EXPECT_EQ(schema.angle_pairs[0].name, "theta_true");
  EXPECT_EQ(schema.angle_pairs[0].unit, "rad");
  EXPECT_EQ(schema.angle_pairs[0].sine, 1);
  ASSERT_EQ(schema.state_sources.size(), 3u);
  EXPECT_EQ(schema.state_sources[0].kind, StateKind::kDerivativeOfMeasured);
  EXPECT_EQ(schema.state_sources[0].output, 0);
  EXPECT_EQ(schema.state_sources[0].cosine, 1);
  EXPECT_EQ(schema.state_sources[1].kind, StateKind::kSineOfMeasured);
  EXPECT_EQ(schema.state_sources[2].kind, StateKind::kCosineOfMeasured);
}

TEST(LogSchema, TellsHiddenStatesFromMeasuredOnes) {
  const LogSchema schema =
      resolve_columns(with_columns({kTime, column("other", ColumnRole::kOutput), kAngle, kVelocity,
                                    column("same", ColumnRole::kState, {.column = "theta"}),
                                    column("alpha_velocity", ColumnRole::kState, {.derivative_of = "alpha"}),
                                    column("alpha", ColumnRole::kIgnored)}));
  EXPECT_EQ(schema.state_sources[0].kind, StateKind::kDerivativeOfMeasured);
  EXPECT_EQ(schema.state_sources[0].output, 1);
  EXPECT_EQ(schema.state_sources[1].kind, StateKind::kMeasured);
  EXPECT_EQ(schema.state_sources[2].kind, StateKind::kHidden);
}

TEST(LogSchema, DerivesFromANameOrElseAHeading) {
  const ColumnConfig renamed = column("arm", ColumnRole::kOutput, {.column = "theta", .wrap = 360.0});
  EXPECT_EQ(resolve_columns(with_columns({kTime, renamed, kVelocity})).states[0].wrap, 360.0);
}

TEST(LogSchema, ReadsTimeInItsUnit) {
  for (const auto& [unit, seconds] : {std::pair{"", 1.0}, {"s", 1.0}, {"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}})
    EXPECT_EQ(
        resolve_columns(with_columns({column("t", ColumnRole::kTime, {.unit = unit}), kAngle, kVelocity})).time_unit_s,
        seconds);
  EXPECT_THAT(error_in({column("t", ColumnRole::kTime, {.unit = "h"}), kAngle, kVelocity}),
              HasSubstr("\"t\": unit \"h\" of the time column: expected s, ms, us or ns"));
}

TEST(LogSchema, DoesWithoutATimeColumnWhenThePeriodIsGiven) {
  LogConfig config = with_columns({kAngle, kVelocity});
  EXPECT_THAT(error_of([&] { resolve_columns(config); }),
              HasSubstr("no column has role \"time\" and sample_period_s is not given"));
  config.sample_period_s = 0.004;
  EXPECT_EQ(resolve_columns(config).time_heading, "");
}

TEST(LogSchema, RefusesWhatDoesNotMakeAnObserver) {
  EXPECT_THAT(error_in({kTime, kVelocity, column("theta", ColumnRole::kIgnored)}),
              HasSubstr("no column has role \"output\""));
  EXPECT_THAT(error_in({kTime, kAngle}), HasSubstr("no column has role \"state\""));
  EXPECT_THAT(error_in({kTime, kTime, kAngle, kVelocity}), HasSubstr("a second column with role \"time\""));
}

TEST(LogSchema, RefusesNamesThatAreTaken) {
  EXPECT_THAT(error_in({kTime, kAngle, column("theta", ColumnRole::kState)}),
              AllOf(HasSubstr("\"theta\": the name is taken"), HasSubstr("two names")));
  ColumnConfig angle = kAngle;
  angle.encoding = Encoding::kSincos;
  EXPECT_THAT(error_in({kTime, angle, kVelocity, column("theta_cos", ColumnRole::kState)}),
              HasSubstr("\"theta_cos\": the name is taken"));
}

TEST(LogSchema, RefusesAnglesThatAreNone) {
  EXPECT_THAT(error_in({kTime, kVelocity, column("theta", ColumnRole::kOutput, {.encoding = Encoding::kSincos})}),
              HasSubstr("needs the angle's wrap"));
  EXPECT_THAT(error_in({kTime, kVelocity, column("theta", ColumnRole::kOutput, {.wrap = -1.0})}),
              HasSubstr("wrap = -1"));
}

TEST(LogSchema, RefusesDerivativesOfNothing) {
  ColumnConfig velocity = kVelocity;
  velocity.derivative_of = "tetha";
  EXPECT_THAT(error_in({kTime, kAngle, velocity}),
              AllOf(HasSubstr("\"omega\": derivative_of = \"tetha\" is not a listed column"),
                    HasSubstr("did you mean \"theta\"?")));
  velocity = kVelocity;
  velocity.wrap = kTurn;
  EXPECT_THAT(error_in({kTime, kAngle, velocity}), HasSubstr("a derivative does not wrap"));
  velocity = kVelocity;
  velocity.role = ColumnRole::kOutput;
  EXPECT_THAT(error_in({kTime, kAngle, velocity}), HasSubstr("derivative_of is for columns with role \"state\""));
}

}  // namespace
}  // namespace nlo::trainer
