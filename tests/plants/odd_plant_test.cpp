// SPDX-License-Identifier: MIT
// Odd plants are recognised; plants that are only nearly odd are refused with a counterexample.
#include "trainer/plants/odd_plant.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "trainer/plants/plant_registry.h"

namespace nlo::trainer {
namespace {

using ::testing::HasSubstr;

std::string counterexample(const PlantConfig& config, const std::vector<std::string>& even,
                           const SimulationConfig& simulation, bool driven = false) {
  const auto plant = make_plant(config);
  return mirror_counterexample(*plant, odd_channels(*plant, even), simulation, driven).value_or("odd");
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

TEST(OddPlant, IsRecognised) {
  const std::vector<std::string> van_der_pol = {"x2", "(1 - x1^2) * x2 - x1"};
  EXPECT_EQ(counterexample(van_der_pol, "x1"), "odd");
  EXPECT_EQ(counterexample(van_der_pol, "x1 + x2^3 + sin(x1)"), "odd");
  EXPECT_EQ(counterexample({"x2", "-x1 + 0 * x1^2"}, "x1"), "odd");
  EXPECT_THAT(counterexample(van_der_pol, "x1 + 0.001 * x2^2"), HasSubstr("the output of y"));
  EXPECT_THAT(counterexample({"x2", "-x1 - 0.001"}, "x1"), HasSubstr("dx/dt of x2"));
  EXPECT_THAT(counterexample(van_der_pol, "cos(x1)"), HasSubstr("the output of y"));
}

TEST(OddPlant, TheLorenzSystemIsRefusedWithACounterexample) {
  const std::string found = counterexample({"10 * (x2 - x1)", "x1 * (28 - x3) - x2", "x1 * x2 - 8 / 3 * x3"}, "x1");
  EXPECT_THAT(found, HasSubstr("at x = ("));
  EXPECT_THAT(found, HasSubstr("and at the mirror image x = ("));
}

TEST(OddPlant, TheLorenzSystemIsOddIfItsThirdStateIsEven) {
  const std::vector<std::string> lorenz = {"10 * (x2 - x1)", "x1 * (28 - x3) - x2", "x1 * x2 - 8 / 3 * x3"};
  EXPECT_EQ(counterexample(lorenz, "x1", {"x3"}), "odd");
  EXPECT_EQ(counterexample(lorenz, "x1^2", {"x3", "y"}), "odd") << "an output may also be even";
  EXPECT_THAT(counterexample(lorenz, "x1^2", {"x3"}), HasSubstr("the output of y"));
  EXPECT_THAT(counterexample(lorenz, "x1", {"x2"}), HasSubstr("and at the mirror image x = ("));
}

TEST(OddPlant, InputsOfADrivenPlantAlsoChangeTheirSign) {
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
  EXPECT_THAT(found("force^2 - v", {}), HasSubstr("and at the mirror image x = ("));
  EXPECT_EQ(found("force^2 - v", {}, false), "odd") << "an input that does not act is ignored";
}

TEST(OddPlant, MakesNoClaimOutsideTheDomainOfThePlant) {
  EXPECT_EQ(counterexample({"x2", "-x1 * sqrt(x1^2 - 100)"}, "x1"), "odd");
}

TEST(OddPlant, ASingleInitialStateIsEnough) {
  PlantConfig plant;
  plant.states = {"a", "b"};
  plant.derivative = {"b", "-a + a^2"};
  plant.outputs = {"a"};
  SimulationConfig simulation;
  simulation.initial_low = simulation.initial_high = {0.0, 0.0};  // at 0 alone, every f with f(0) = 0 looks odd
  EXPECT_NE(counterexample(plant, {}, simulation), "odd");
}

TEST(OddPlant, TheBuiltInOscillatorsAreOdd) {
  for (const char* name : {"van_der_pol", "reverse_duffing", "harmonic_oscillator"}) {
    PlantConfig plant;
    plant.model = name;
    SimulationConfig simulation;
    simulation.initial_low = {-1.0, -1.0};
    simulation.initial_high = {1.0, 1.0};
    EXPECT_EQ(counterexample(plant, {}, simulation), "odd") << name;
  }
}

}  // namespace
}  // namespace nlo::trainer
