// SPDX-License-Identifier: MIT
#include "trainer/compare/conditions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codegen/base/error.h"
#include "tests/compare/plants.h"
#include "trainer/compare/compare_study.h"

namespace nlo::trainer {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;
using testing::HasSubstr;
using testing::StartsWith;

const VectorXd kOutput = VectorXd::Constant(1, 1.41);
const VectorXd kStates = Vector2d(1.41, 1.4);

std::string refusal(const std::string& text) {
  try {
    std::vector<std::string> left_out;
    (void)conditions_of(parse_conditions(text, "mine.toml"), {{"mu", 1.0}}, kOutput, kStates, left_out);
  } catch (const codegen::Error& error) {
    return error.what();
  }
  return "";
}

TEST(Conditions, ThatAreWrongAreNamedWithTheirLineAndTheMend) {
  struct Case {
    std::string text, message;
  };
  for (const auto& [text, message] : std::vector<Case>{
           {"", "mine.toml: there is no condition"},
           {"condition = []", "mine.toml: there is no condition"},
           {"condition = 3", "mine.toml:1: [[condition]]"},
           {"condition = [3]", "mine.toml:1: condition is an integer"},
           {"[condition]\nname = \"a\"", "mine.toml:1: [[condition]]"},
           {"[[condition]]\nnoise = \"none\"", "mine.toml:1: a condition has no name"},
           {"[[condition]]\nname = \"a b\"", "mine.toml:2: [[condition]] name"},
           {"[[condition]]\nname = \"a\"\nnose = \"none\"",
            "mine.toml:3: unknown key \"nose\" in [[condition]]; did you "
            "mean \"noise\"?"},
           {"noise = \"none\"",
            "mine.toml:1: unknown key \"noise\" in a file of conditions; it belongs in [[condition]]"},
           {"[[condition]]\nname = \"a\"\nnoise = \"gausian:1\"", "mine.toml:3: [[condition]] noise"},
           {"[[condition]]\nname = \"a\"\nnoise = [\"none\", \"none\"]", "is of 2 outputs, but there is 1"},
           {"[[condition]]\nname = \"a\"\nparameter_factor = -1", "mine.toml:3: [[condition]] parameter_factor"},
           {"[[condition]]\nname = \"a\"\nparameters = { mi = 2 }",
            "mine.toml:1: condition \"a\" changes the parameter \"mi\""},
           {"[[condition]]\nname = \"a\"\nparameters = { mu = [1, 2] }", "is a range"},
           {"[[condition]]\nname = \"a\"\nprocess_noise = [1, 2, 3]",
            "has process_noise of 3 states, but the plant has 2"},
           {"[[condition]]\nname = \"a\"\nbox_scale = 0", "mine.toml:3: [[condition]] box_scale"},
           {"[[condition]]\nname = \"a\"\n[[condition]]\nname = \"a\"", "mine.toml:3: condition \"a\" is there twice"},
           {"[[condition]\nname", "mine.toml:"},
           {std::string(5000, '['), "mine.toml"},
       })
    EXPECT_THAT(refusal(text), HasSubstr(message)) << text;
  EXPECT_EQ(refusal("[[condition]]\nname = \"a\"\nparameters = { mu = 1.2 }\nnoise = \"gaussian:0.5+missing:0.2\""), "")
      << "control: a right one is taken";
}

TEST(Conditions, WrittenForADeviationAreScaledByRoundNumbers) {
  EXPECT_EQ(round_factor(1.01), 1.0);
  EXPECT_EQ(round_factor(0.3), 0.2);
  EXPECT_EQ(round_factor(40.0), 50.0);
  EXPECT_EQ(round_factor(8.0), 10.0);
  EXPECT_EQ(round_factor(0.0), 1.0);
  std::vector<std::string> left_out;
  const auto own = conditions_of(default_conditions(), {{"mu", 1.0}}, kOutput, kStates, left_out);
  ASSERT_EQ(own.size(), default_conditions().conditions.size());
  for (std::size_t i = 0; i < own.size(); ++i) EXPECT_EQ(own[i].noise, default_conditions().conditions[i].noise);
  EXPECT_TRUE(left_out.empty());

  const auto larger = conditions_of(default_conditions(), {}, 100.0 * kOutput, Vector2d(141.0, 0.0141), left_out);
  EXPECT_EQ(left_out.size(), 5u) << "those that change a plant's parameters";
  const auto named = [&](const std::string& name) {
    return *std::find_if(larger.begin(), larger.end(),
                         [&](const Condition& condition) { return condition.name == name; });
  };
  EXPECT_EQ(format_noise(named("gaussian").noise), "gaussian:50");
  EXPECT_EQ(format_noise(named("mixture").noise), "gaussian:50+outliers:0.05:1000+bias:20+quantised:25+missing:0.2");
  EXPECT_THAT(named("process_noise").process_noise, testing::ElementsAre(10.0, 0.001));
}

TEST(Conditions, AsShippedAreUnderstoodForEveryBuiltInPlant) {
  std::vector<std::string> left_out;
  EXPECT_EQ(compared_conditions(test::van_der_pol(), default_conditions(), left_out).size(), 20u);
}

}  // namespace
}  // namespace nlo::trainer
