// SPDX-License-Identifier: MIT
// Tests which channels a Sensor for SimpleFOC uses as angle and velocity of the shaft, and its errors if they are
// ambiguous. compile_wrappers.sh flies it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "codegen/targets/around_c99.h"
#include "tests/codegen/example_models.h"
#include "tests/support/thrown_message.h"

namespace nlo::codegen {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::string sensor_of(const Model& model, const std::string& roles = "") {
  ExportOptions options;
  options.roles = roles;
  for (const NamedText& file : simplefoc(PreparedExport(model, options)))
    if (file.path == "src/" + model.name + "_sensor.h") return file.text;
  return "";
}

std::string refusal_of(const Model& model, const std::string& roles = "") {
  return thrown_message([&] { sensor_of(model, roles); });
}

TEST(SimpleFoc, UnitsIdentifyTheAngleAndTheVelocity) {
  const std::string sensor = sensor_of(rig_model());
  EXPECT_THAT(sensor, HasSubstr("y[rig_output_alpha] = static_cast<float>(angle_prev)"));  // an angle with a wrap
  EXPECT_THAT(sensor, HasSubstr("return static_cast<float>(x_hat_[rig_state_alpha_dot])"));
  Model straight = rig_model();
  straight.outputs[0].unit = "m";  // then no output is the encoder
  EXPECT_THAT(sensor_of(straight), Not(HasSubstr("y[rig_output_alpha]")));
  EXPECT_THAT(sensor_of(rig_model(), "angle=none"), Not(HasSubstr("y[rig_output_alpha]")));
}

TEST(SimpleFoc, NamesIdentifyChannelsWithoutUnits) {
  Model m = rig_model();
  for (Channel& channel : m.outputs) channel.unit.clear();
  for (Channel& channel : m.states) channel.unit.clear();
  EXPECT_THAT(refusal_of(m), HasSubstr("which output is the angle; give it the unit rad, or write --roles "
                                       "angle=NAME with one of alpha, load, or none"));
  m.outputs[0].name = "theta";
  EXPECT_THAT(refusal_of(m), HasSubstr("which state is the velocity;"));
  m.states[1].name = "omega";
  EXPECT_THAT(sensor_of(m), HasSubstr("x_hat_[rig_state_omega]"));
}

TEST(SimpleFoc, AsksForRolesIfSeveralChannelsFit) {
  Model m = rig_model();
  m.states[1].unit = "rad/s";
  EXPECT_THAT(refusal_of(m), HasSubstr("both alpha_dot and load_dot could be the velocity; write --roles velocity=NAME "
                                       "with one of alpha_dot [rad/s], load_dot [rad/s], phase [rad]"));
  EXPECT_THAT(sensor_of(m, "velocity=load_dot"), HasSubstr("x_hat_[rig_state_load_dot]"));
}

TEST(SimpleFoc, RefusesOtherUnitsAndTurns) {
  Model m = rig_model();
  m.outputs[0].unit = "deg";
  EXPECT_THAT(refusal_of(m), HasSubstr("which output is the angle;"));
  EXPECT_THAT(refusal_of(m, "angle=alpha"), HasSubstr("its unit is deg, but SimpleFOC uses rad"));
  EXPECT_THAT(refusal_of(rig_model(), "velocity=load_dot"), HasSubstr("its unit is N/s, but SimpleFOC uses rad/s"));
  EXPECT_THAT(refusal_of(rig_model(), "velocity=alpha_dot,speed=phase"), HasSubstr("there is no role \"speed\""));
  EXPECT_THAT(refusal_of(rig_model(), "velocity"), HasSubstr("--roles: \"velocity\" is not KEY=VALUE"));
}

}  // namespace
}  // namespace nlo::codegen
