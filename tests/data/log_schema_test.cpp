// SPDX-License-Identifier: MIT
#include "trainer/data/log_schema.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/data/data_testing.h"

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
  return thrown_message([&] { resolve_columns(with_columns(std::move(columns))); });
}

const ColumnConfig kTime = column("t", ColumnRole::kTime, {.column = "time"});
const ColumnConfig kAngle = column("theta", ColumnRole::kOutput, {.unit = "rad", .wrap = kTurn});
const ColumnConfig kVelocity = column("omega", ColumnRole::kState, {.unit = "rad/s", .derivative_of = "theta"});

TEST(LogSchema, MakesChannelsFromColumnsInTheirOrder) {
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
  EXPECT_EQ(schema.states[0].wrap, kTurn);  // the angle from which the velocity is derived wraps
  EXPECT_EQ(schema.states[1].heading, "pos");
  EXPECT_EQ(schema.inputs.size(), 1u);
}

ColumnConfig computed(const char* name, const char* expression) {
  ColumnConfig result = column(name, ColumnRole::kOutput);
  result.expression = expression;
  return result;
}

TEST(LogSchema, PutsComputedOutputsAfterMeasuredOnes) {
  ColumnConfig angle = kAngle;
  const ColumnConfig speed = column("v", ColumnRole::kOutput, {.unit = "m/s"});
  angle.encoding = Encoding::kSincos;
  const LogSchema schema =
      resolve_columns(with_columns({computed("p", "theta_sin * u"), kTime, angle, kVelocity, computed("q", "v * u^3"),
                                    column("u", ColumnRole::kInput), computed("r", "v + u"), speed}));
  ASSERT_EQ(schema.output_channels.size(), 6u);
  EXPECT_EQ(schema.output_channels[2].name, "v");
  EXPECT_EQ(schema.output_channels[3].name, "p");
  EXPECT_EQ(schema.output_channels[4].expression, "v * u^3");
  EXPECT_EQ(schema.outputs.size(), 2u);  // the two columns of the file
}

TEST(LogSchema, RefusesComputedOutputsThatFlightCouldNotCompute) {
  const ColumnConfig load = column("load", ColumnRole::kOutput);
  EXPECT_THAT(
      error_in({kTime, kAngle, load, kVelocity, computed("p", "theta * load")}),
      AllOf(HasSubstr("\"p\""), HasSubstr("reads \"theta\""), HasSubstr("does not wrap"), HasSubstr("there is load")));
  EXPECT_THAT(error_in({kTime, load, kVelocity, kAngle, computed("p", "load * omega")}), HasSubstr("reads \"omega\""));
  EXPECT_THAT(error_in({kTime, load, kVelocity, kAngle, computed("p", "load^2"), computed("q", "load * p")}),
              AllOf(HasSubstr("\"q\""), HasSubstr("reads \"p\"")));
  ColumnConfig state = computed("p", "load^2"), wrapped = computed("p", "load^2"), named = computed("p", "load^2");
  state.role = ColumnRole::kState;
  wrapped.wrap = kTurn;
  named.column = "power";
  EXPECT_THAT(error_in({kTime, load, kVelocity, kAngle, state}), HasSubstr("role \"output\""));
  EXPECT_THAT(error_in({kTime, load, kVelocity, kAngle, wrapped}), HasSubstr("remove wrap, or the expression"));
  EXPECT_THAT(error_in({kTime, load, kVelocity, kAngle, named}), HasSubstr("remove column, or the expression"));
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

TEST(LogSchema, DistinguishesHiddenFromMeasuredStates) {
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

TEST(LogSchema, FindsTheColumnOfADerivativeByNameOrHeading) {
  const ColumnConfig renamed = column("arm", ColumnRole::kOutput, {.column = "theta", .wrap = 360.0});
  EXPECT_EQ(resolve_columns(with_columns({kTime, renamed, kVelocity})).states[0].wrap, 360.0);
}

TEST(LogSchema, ReadsTimeInItsUnit) {
  for (const auto& [unit, seconds] : {std::pair{"", 1.0}, {"s", 1.0}, {"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}})
    EXPECT_EQ(
        resolve_columns(with_columns({column("t", ColumnRole::kTime, {.unit = unit}), kAngle, kVelocity})).time_unit_s,
        seconds);
  EXPECT_THAT(error_in({column("t", ColumnRole::kTime, {.unit = "m"}), kAngle, kVelocity}),
              HasSubstr("\"t\": unit \"m\" of the time column: expected s, ms, us, ns, min or h"));
}

TEST(LogSchema, NeedsNoTimeColumnIfThePeriodIsGiven) {
  LogConfig config = with_columns({kAngle, kVelocity});
  EXPECT_THAT(thrown_message([&] { resolve_columns(config); }),
              HasSubstr("no column has role \"time\" and sample_period_s is not given"));
  config.sample_period_s = 0.004;
  EXPECT_EQ(resolve_columns(config).time_heading, "");
}

TEST(LogSchema, RefusesColumnsWithoutOutputOrState) {
  EXPECT_THAT(error_in({kTime, kVelocity, column("theta", ColumnRole::kIgnored)}),
              HasSubstr("no column has role \"output\""));
  EXPECT_THAT(error_in({kTime, kAngle}), HasSubstr("no column has role \"state\""));
  EXPECT_THAT(error_in({kTime, kTime, kAngle, kVelocity}), HasSubstr("a second column with role \"time\""));
}

TEST(LogSchema, RefusesDuplicateNames) {
  EXPECT_THAT(error_in({kTime, kAngle, column("theta", ColumnRole::kState)}),
              AllOf(HasSubstr("\"theta\": the name is used twice"), HasSubstr("two names")));
  ColumnConfig angle = kAngle;
  angle.encoding = Encoding::kSincos;
  EXPECT_THAT(error_in({kTime, angle, kVelocity, column("theta_cos", ColumnRole::kState)}),
              HasSubstr("\"theta_cos\": the name is used twice"));
}

TEST(LogSchema, RefusesInvalidAngles) {
  EXPECT_THAT(error_in({kTime, kVelocity, column("theta", ColumnRole::kOutput, {.encoding = Encoding::kSincos})}),
              HasSubstr("needs the angle's wrap"));
  EXPECT_THAT(error_in({kTime, kVelocity, column("theta", ColumnRole::kOutput, {.wrap = -1.0})}),
              HasSubstr("wrap = -1"));
}

TEST(LogSchema, RefusesDerivativesOfUnknownColumns) {
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

ColumnConfig converted(ColumnConfig column, const std::string& file_unit, double scale = 1.0, double offset = 0.0) {
  column.file_unit = file_unit;
  column.scale = scale;
  column.offset = offset;
  return column;
}

TEST(LogSchema, ConvertsCellsByScaleAndOffsetAndThenFromTheirUnit) {
  const auto height = column("height", ColumnRole::kState, {.unit = "m"});
  const auto cells_of = [&](const ColumnConfig& state) {
    const LogColumn resolved = resolve_columns(with_columns({kTime, kAngle, state})).states[0];
    return std::pair(resolved.scale, resolved.offset);
  };
  EXPECT_EQ(cells_of(height), std::pair(1.0, 0.0));
  EXPECT_EQ(cells_of(converted(height, "m")), std::pair(1.0, 0.0));
  EXPECT_EQ(cells_of(converted(height, "", 0.5, 3.0)), std::pair(0.5, 3.0));
  EXPECT_EQ(cells_of(converted(height, "cm")), std::pair(0.01, 0.0));
  EXPECT_EQ(cells_of(converted(height, "cm", 2.0, 50.0)), std::pair(0.02, 0.5));  // 2 cell + 50 [cm]
  const auto warm = cells_of(converted(column("warm", ColumnRole::kState, {.unit = "K"}), "degC", 0.1, -40.0));
  EXPECT_DOUBLE_EQ(warm.first, 0.1);
  EXPECT_DOUBLE_EQ(warm.second, 233.15);
}

TEST(LogSchema, RefusesInvalidConversions) {
  const auto height = column("height", ColumnRole::kState, {.unit = "m"});
  EXPECT_THAT(
      error_in({kTime, kAngle, converted(height, "V")}),
      HasSubstr("\"height\": file_unit = \"V\" (voltage) cannot be converted to unit = \"m\" (length): they measure "
                "different kinds of quantities"));
  EXPECT_THAT(
      error_in({kTime, kAngle, converted(height, "cubit")}),
      AllOf(HasSubstr("file_unit = \"cubit\" cannot be converted to unit = \"m\" (length): the table of units does not "
                      "have both"),
            HasSubstr("value = scale * cell + offset")));
  EXPECT_THAT(error_in({kTime, kAngle, converted(column("height", ColumnRole::kState), "cm")}),
              HasSubstr("file_unit = \"cm\" needs unit"));
  EXPECT_THAT(error_in({kTime, kAngle, converted(height, "", 0.0)}), HasSubstr("scale = 0 makes every value the same"));
  EXPECT_THAT(error_in({converted(kTime, "", 2.0), kAngle, kVelocity}), HasSubstr("are not for the time column"));
  EXPECT_THAT(error_in({kTime, kAngle, converted(kVelocity, "", 2.0)}), HasSubstr("set them at \"theta\""));
}

TEST(LogSchema, AVelocityIsConvertedToItsUnit) {
  const auto rate_of = [](const ColumnConfig& angle, const ColumnConfig& velocity) {
    return resolve_columns(with_columns({kTime, angle, velocity})).states[0].rate;
  };
  ColumnConfig degrees = column("theta", ColumnRole::kOutput, {.unit = "deg", .wrap = 360.0});
  ColumnConfig velocity = kVelocity;
  EXPECT_EQ(rate_of(kAngle, velocity), 1.0);
  EXPECT_DOUBLE_EQ(rate_of(degrees, velocity), kTurn / 360.0);  // deg/s, converted to rad/s
  velocity.unit = "rpm";
  EXPECT_DOUBLE_EQ(rate_of(kAngle, velocity), 60.0 / kTurn);
  velocity.unit = "knots";  // not in the table of units, so nothing is converted
  EXPECT_EQ(rate_of(degrees, velocity), 1.0);
  EXPECT_EQ(rate_of(degrees, converted(kVelocity, "deg/s")), kTurn / 360.0);
  velocity.unit = "m/s";
  EXPECT_THAT(
      error_in({kTime, kAngle, velocity}),
      HasSubstr(
          "\"omega\": unit = \"m/s\" (speed) cannot be the unit of the derivative of \"theta\", which is in \"rad\" "
          "(angle): expected one of angular velocity"));
}

TEST(LogSchema, AStateInAnotherUnitThanItsOutputIsNotMeasuredByIt) {
  const auto kind_of = [](const std::string& file_unit) {
    ColumnConfig state = column("truth", ColumnRole::kState, {.column = "theta", .unit = "rad", .wrap = kTurn});
    state.file_unit = file_unit;
    return resolve_columns(with_columns({kTime, kAngle, state})).state_sources[0].kind;
  };
  EXPECT_EQ(kind_of(""), StateKind::kMeasured);
  EXPECT_EQ(kind_of("deg"), StateKind::kHidden);
}

}  // namespace
}  // namespace nlo::trainer
