// SPDX-License-Identifier: MIT
// Expressions that are linear are seen to be, and what only looks like it is not taken for it.
#include "trainer/plants/recognise_linear.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "trainer/plants/registry.h"

namespace nlo::trainer {
namespace {

std::unique_ptr<Plant> two_states(const std::vector<std::string>& derivative, const std::string& output) {
  PlantConfig config;
  config.states = {"p", "v"};
  config.derivative = derivative;
  config.output_names = {"y"};
  config.outputs = {output};
  config.parameters = {{"m", 0.7}, {"c", 0.3}, {"g", 9.81}};
  return make_plant(config);
}

Linearity recognised(const std::vector<std::string>& derivative, const std::string& output) {
  return recognise_linear(*two_states(derivative, output), Eigen::Vector2d(1.0, 2.0));
}

TEST(RecogniseLinear, FindsTheMatricesOfLinearExpressions) {
  const Linearity found = recognised({"v", "-(p - v / 3) / m - c * v * 2"}, "p + 0.5 * v");
  ASSERT_TRUE(found.plant);
  EXPECT_FALSE(found.affine);
  Eigen::Matrix2d a;
  a << 0.0, 1.0, -1.0 / 0.7, 1.0 / 2.1 - 0.6;
  EXPECT_LT((found.plant->a() - a).norm(), 1e-15);
  EXPECT_EQ(found.plant->c(), Eigen::RowVector2d(1.0, 0.5));
  EXPECT_EQ(found.plant->outputs().front().name, "y");
}

TEST(RecogniseLinear, SeesWhatIsNotLinear) {
  const std::vector<std::string> linear = {"v", "-p"};
  ASSERT_TRUE(recognised(linear, "p").plant) << "control";
  for (const char* nonlinear : {"-sin(p)", "-p - 1e-9 * p^3", "-p * v", "-abs(p)", "max(-50, min(50, -p))",
                                "-p / (1 + 1e-12 * v^2)", "abs(p) < 0.01 ? 0 : -p", "-sqrt(p)", "-sin(1e-6 * p)"}) {
    const Linearity found = recognised({"v", nonlinear}, "p");
    EXPECT_FALSE(found.plant) << nonlinear;
    EXPECT_FALSE(found.affine) << nonlinear;
  }
  EXPECT_FALSE(recognised(linear, "p^2").plant);
}

TEST(RecogniseLinear, TellsOffsetsFromTheRest) {
  const Linearity falling = recognised({"v", "-c * v - g"}, "p");
  EXPECT_FALSE(falling.plant);
  EXPECT_TRUE(falling.affine);
  EXPECT_TRUE(recognised({"v", "-p"}, "p - 0.2").affine);
}

TEST(RecogniseLinear, KnowsTheBuiltInPlants) {
  for (const PlantEntry& entry : plant_registry()) {
    PlantConfig config;
    config.model = entry.name;
    const auto plant = make_plant(config);
    const Linearity found = recognise_linear(*plant, Eigen::VectorXd::Ones(plant->nx()));
    EXPECT_EQ(found.plant != nullptr, entry.name == "harmonic_oscillator") << entry.name;
  }
}

}  // namespace
}  // namespace nlo::trainer
