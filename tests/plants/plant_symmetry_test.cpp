// SPDX-License-Identifier: MIT
// A symmetry that the equations have is found, and one that they only nearly have is refused with numbers.
#include "trainer/plants/plant_symmetry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "trainer/plants/registry.h"

namespace nlo::trainer {
namespace {

using ::testing::HasSubstr;

std::string counterexample(const PlantConfig& config, const std::vector<std::string>& even,
                           const SimulationConfig& simulation, bool driven = false) {
  const auto plant = make_plant(config);
  return symmetry_counterexample(*plant, odd_symmetry(*plant, even), simulation, driven).value_or("odd");
}

std::string counterexample(const std::vector<std::string>& derivative, const std::string& output,
                           const std::vector<std::string>& even = {}) {
  PlantConfig plant;
  for (std::size_t i = 0; i < derivative.size(); ++i) plant.states.push_back("x" + std::to_string(i + 1));
  plant.derivative = derivative;
  plant.outputs = {output};
  SimulationConfig simulation;
  simulation.initial_low.assign(derivative.size(), -2.0);
  simulation.initial_high.assign(derivative.size(), 3.0);
  return counterexample(plant, even, simulation);
}

TEST(OddSymmetry, IsFoundInOddPlantsAndOnlyThere) {
  const std::vector<std::string> van_der_pol = {"x2", "(1 - x1^2) * x2 - x1"};
  EXPECT_EQ(counterexample(van_der_pol, "x1"), "odd");
  EXPECT_EQ(counterexample(van_der_pol, "x1 + x2^3 + sin(x1)"), "odd");
  EXPECT_EQ(counterexample({"x2", "-x1 + 0 * x1^2"}, "x1"), "odd");
  EXPECT_THAT(counterexample(van_der_pol, "x1 + 0.001 * x2^2"), HasSubstr("the output of y"));
  EXPECT_THAT(counterexample({"x2", "-x1 - 0.001"}, "x1"), HasSubstr("dx/dt of x2"));
  EXPECT_THAT(counterexample(van_der_pol, "cos(x1)"), HasSubstr("the output of y"));
}

TEST(OddSymmetry, TheLorenzSystemIsRefusedWithACounterexample) {
  const std::string found = counterexample({"10 * (x2 - x1)", "x1 * (28 - x3) - x2", "x1 * x2 - 8 / 3 * x3"}, "x1");
  EXPECT_THAT(found, HasSubstr("at x = ("));
  EXPECT_THAT(found, HasSubstr("and at the image x = ("));
}

TEST(OddSymmetry, TheLorenzSystemTurnsAboutItsThirdAxis) {
  const std::vector<std::string> lorenz = {"10 * (x2 - x1)", "x1 * (28 - x3) - x2", "x1 * x2 - 8 / 3 * x3"};
  EXPECT_EQ(counterexample(lorenz, "x1", {"x3"}), "odd");
  EXPECT_EQ(counterexample(lorenz, "x1^2", {"x3", "y"}), "odd") << "an output may be even, too";
  EXPECT_THAT(counterexample(lorenz, "x1^2", {"x3"}), HasSubstr("the output of y"));
  EXPECT_THAT(counterexample(lorenz, "x1", {"x2"}), HasSubstr("and at the image x = ("));
}

TEST(OddSymmetry, OfADrivenPlantTheInputTurnsToo) {
  PlantConfig plant;
  plant.states = {"v"};
  plant.outputs = {"v"};
  plant.output_names = {"speed"};
  SimulationConfig simulation;
  simulation.initial_low = {-2.0};
  simulation.initial_high = {3.0};
  const auto found = [&](const std::string& derivative, const std::vector<std::string>& even, bool driven = true) {
    plant.derivative = {derivative};
    plant.inputs = {"force"};
    if (derivative.find("drag") != std::string::npos) plant.inputs.emplace_back("drag");
    return counterexample(plant, even, simulation, driven);
  };
  EXPECT_EQ(found("force + 0.1 * force^3 - v", {}), "odd");
  EXPECT_EQ(found("force - drag * v", {"drag"}), "odd") << "a coefficient keeps its sign";
  EXPECT_THAT(found("force - drag * v", {}), HasSubstr("u = ("));
  EXPECT_THAT(found("force^2 - v", {}), HasSubstr("and at the image x = ("));
  EXPECT_EQ(found("force^2 - v", {}, false), "odd") << "where no input acts, none is asked";
}

TEST(OddSymmetry, WhereThePlantHasNoValueNothingIsClaimed) {
  EXPECT_EQ(counterexample({"x2", "-x1 * sqrt(x1^2 - 100)"}, "x1"), "odd");
}

TEST(OddSymmetry, OneInitialStateIsEnoughToLookAround) {
  PlantConfig plant;
  plant.states = {"a", "b"};
  plant.derivative = {"b", "-a + a^2"};
  plant.outputs = {"a"};
  SimulationConfig simulation;
  simulation.initial_low = simulation.initial_high = {0.0, 0.0};  // where every f(0) = 0 looks odd
  EXPECT_NE(counterexample(plant, {}, simulation), "odd");
}

TEST(OddSymmetry, TheBuiltInOscillatorsAreOdd) {
  for (const char* name : {"van_der_pol", "reverse_duffing", "harmonic_oscillator"}) {
    PlantConfig plant;
    plant.model = name;
    SimulationConfig simulation;
    simulation.initial_low = {-1.0, -1.0};
    simulation.initial_high = {1.0, 1.0};
    EXPECT_EQ(counterexample(plant, {}, simulation), "odd") << name;
  }
}

/// Two unit masses of the plane, which a spring holds together; a force acts on the first.
PlantConfig two_bodies(const std::string& spring = "1") {
  PlantConfig plant;
  plant.states = {"x1", "y1", "x2", "y2", "vx1", "vy1", "vx2", "vy2"};
  plant.inputs = {"fx", "fy"};
  plant.derivative = {
      "vx1", "vy1", "vx2", "vy2", "x2 - x1 + fx", spring + " * (y2 - y1) + fy", "x1 - x2", spring + " * (y1 - y2)"};
  plant.output_names = {"mx", "my", "apart"};
  plant.outputs = {"x1 + x2", "y1 + y2", "(x1 - x2)^2 + (y1 - y2)^2"};
  return plant;
}

std::string found(const PlantConfig& config, const SymmetryConfig& symmetry, bool driven = true) {
  SimulationConfig simulation;
  simulation.initial_low.assign(config.states.size(), -2.0);
  simulation.initial_high.assign(config.states.size(), 3.0);
  return symmetry_counterexample(*make_plant(config), symmetry, simulation, driven).value_or("none");
}

TEST(PlantSymmetry, AnyTurnOfAPlanarPlantIsFoundAndOneThatLeavesOutAVectorIsNot) {
  SymmetryConfig turns{.kind = "rotation2", .vectors = {{"x1", "y1"}, {"x2", "y2"}, {"vx1", "vy1"}, {"vx2", "vy2"}}};
  turns.vectors.push_back({"mx", "my"});
  EXPECT_THAT(found(two_bodies(), turns), HasSubstr("dx/dt of vx1")) << "the force has a direction";
  EXPECT_EQ(found(two_bodies(), turns, false), "none") << "where no input acts, none is asked";
  turns.vectors.push_back({"fx", "fy"});
  EXPECT_EQ(found(two_bodies(), turns), "none");
  EXPECT_THAT(found(two_bodies("1.001"), turns), HasSubstr("the symmetry has")) << "a spring that is stiffer in y";
  turns.vectors.erase(turns.vectors.begin() + 4);
  EXPECT_THAT(found(two_bodies(), turns), HasSubstr("the output of mx"));
}

TEST(PlantSymmetry, WhatIsAlikeMayChangePlacesButNotWhatAForceTellsApart) {
  const SymmetryConfig swap{.kind = "permutation",
                            .vectors = {{"x1", "x2"}, {"y1", "y2"}, {"vx1", "vx2"}, {"vy1", "vy2"}}};
  EXPECT_EQ(found(two_bodies(), swap, false), "none");
  EXPECT_THAT(found(two_bodies(), swap), HasSubstr("dx/dt of vx"));
}

/// A pendulum without weight that a field of six poles holds; its encoder counts turns.
TEST(PlantSymmetry, AFoldOfATurnIsFoundAndWhatItsPolesTellApartIsNot) {
  PlantConfig rotor;
  rotor.states = {"theta", "omega"};
  rotor.state_wraps = {6.283185307179586, 0.0};
  rotor.derivative = {"omega", "-sin(6 * theta)"};
  rotor.output_names = {"angle"};
  rotor.outputs = {"atan2(sin(theta), cos(theta))"};
  rotor.output_wraps = {6.283185307179586};
  SymmetryConfig shift{.kind = "shift", .channels = {"theta", "angle"}, .fold = 6};
  EXPECT_EQ(found(rotor, shift, false), "none");
  for (const int fold : {0, 4}) {
    shift.fold = fold;
    EXPECT_THAT(found(rotor, shift, false), HasSubstr("dx/dt of omega")) << fold;
  }
}

TEST(PlantSymmetry, OfARigidBodyAnyRotationIsFound) {
  PlantConfig body;  // a direction that is seen from a body which turns at the rate w
  body.states = {"ux", "uy", "uz"};
  body.inputs = {"wx", "wy", "wz"};
  body.derivative = {"uy * wz - uz * wy", "uz * wx - ux * wz", "ux * wy - uy * wx"};
  body.output_names = {"ax", "ay", "az"};
  body.outputs = {"ux", "uy", "uz"};
  SymmetryConfig rotation{.kind = "rotation3", .vectors = {{"ux", "uy", "uz"}, {"wx", "wy", "wz"}, {"ax", "ay", "az"}}};
  EXPECT_EQ(found(body, rotation), "none");
  body.derivative[0] += " - 0.001 * ux";
  EXPECT_THAT(found(body, rotation), HasSubstr("dx/dt of u"));
}

}  // namespace
}  // namespace nlo::trainer
