// SPDX-License-Identifier: MIT
// What is no symmetry, or cannot be one of this observer, is refused where it was written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/experiments/experiment_text.h"

namespace nlo::trainer {
namespace {

using ::testing::HasSubstr;

/// Line 5: [plant]; line 12: [[symmetry]]; line 16: [observer].
const std::string kPlanar = R"toml(name = "planar"
[simulation]
initial_low = [-1.0, -1.0, -1.0]
initial_high = [1.0, 1.0, 1.0]
[plant]
states = ["x", "y", "a"]
state_wraps = [0, 0, "2pi"]
state_encodings = ["unwrap", "unwrap", "sincos"]
derivative = ["0.4 * y", "-0.4 * x", "0.3 * (x * cos(a) + y * sin(a))"]
output_names = ["mx", "my"]
outputs = ["x", "y"]
[[symmetry]]
kind = "rotation2"
vectors = [["x", "y"], ["mx", "my"]]
channels = ["a"]
[observer]
eigenvalues = [-1.0]
)toml";

TEST(SymmetryErrors, OfAPlantNameTheKeyTheEquationAndACounterexample) {
  EXPECT_EQ(error_of(kPlanar), "no error") << "control";
  EXPECT_EQ(error_of(with(kPlanar, "channels = [\"a\"]\n", "channels = [\"a\"]\nfold = 5\n")), "no error");
  expect_rows(
      kPlanar,
      {
          {"channels = [\"a\"]", "", "e.toml:12", "[[symmetry]] rotation2 is not a symmetry of the plant: at x = ("},
          {"[\"x\", \"y\"], [\"mx\", \"my\"]", "[\"x\", \"y\"]", "e.toml:12", "the output of mx is"},
          {"-0.4 * x", "-0.41 * x", "e.toml:12", "dx/dt of x is"},
          {"\"rotation2\"", "\"rotation4\"", "e.toml:13", "use \"rotation2\"?"},
          {"\"rotation2\"", "\"rotation3\"", "e.toml:12", "has no channels; name its vectors"},
          {"kind = \"rotation2\"", "", "e.toml:12", "has no kind; write one of sign, rotation2"},
          {"], [\"mx\", \"my\"]", "], [\"mx\"]", "e.toml:12",
           "has the vector (mx); each of its vectors has 2 components"},
          {"], [\"mx\", \"my\"]", "], [\"mx\", \"mz\"]", "e.toml:12", "names \"mz\", which is not an output"},
          {"], [\"mx\", \"my\"]", "], [\"mx\", \"y\"]", "e.toml:12", "names \"y\" twice"},
          {"[\"x\", \"y\"], [\"mx\", \"my\"]", "[\"x\", \"my\"], [\"y\", \"mx\"]", "e.toml:12",
           "turns x and my into each other, and x is an estimated state where my is not one"},
          {"[\"x\", \"y\"], [\"mx\", \"my\"]", "[\"x\", \"a\"]", "e.toml:12", "names \"a\" twice"},
          {"state_encodings = [\"unwrap\", \"unwrap\", \"sincos\"]\n", "", "e.toml:11",
           "moves the estimated state a, and no function of z counts turns"},
          {"state_wraps = [0, 0, \"2pi\"]\nstate_encodings = [\"unwrap\", \"unwrap\", \"sincos\"]\n", "", "e.toml:10",
           "moves a, which is not an angle"},
          {"states = [\"x\"", "state_units = [\"m\", \"cm\", \"\"]\nstates = [\"x\"", "e.toml:13",
           "turns x [m] and y [cm] into each other"},
          {"states = [\"x\"", "estimated = [\"x\", \"a\"]\nstates = [\"x\"", "e.toml:13",
           "turns x and y into each other, and x is an estimated state where y is not one"},
          {"channels = [\"a\"]", "channels = [\"a\"]\nby_construction = true", "e.toml:16",
           "structure = \"kkl\" has parameters for which its estimates do not turn with its readings"},
      });
  EXPECT_EQ(error_of(kPlanar, {"symmetry=[]"}), "no error");
  EXPECT_THAT(error_of(kPlanar, {"symmetry={}"}), HasSubstr("[[symmetry]]"));
}

TEST(SymmetryErrors, OfLogsNameWhatTheColumnsTell) {
  const std::string log = R"(name = "planar"
[log]
sample_period_s = 0.01
train_files = ["a.csv"]
[[log.columns]]
name = "px"
role = "output"
unit = "m"
[[log.columns]]
name = "py"
role = "output"
unit = "m"
[[log.columns]]
name = "vx"
role = "state"
derivative_of = "px"
[[log.columns]]
name = "vy"
role = "state"
derivative_of = "py"
[[log.columns]]
name = "area"
role = "output"
expression = "px * py"
[[symmetry]]
kind = "rotation2"
vectors = [["px", "py"], ["vx", "vy"]]
[observer]
eigenvalues = [-1.0]
)";
  EXPECT_EQ(error_of(log), "no error") << "control";
  expect_rows(log,
              {
                  {", [\"vx\", \"vy\"]", "", "e.toml:25", "does not turn vx and px alike"},
                  {"[\"vx\", \"vy\"]", "[\"vy\", \"vx\"]", "e.toml:25", "does not turn vx and px alike"},
                  {"vectors = ", "channels = [\"area\"]\nvectors = ", "e.toml:25", "names area, which is computed"},
                  {"vectors = ", "channels = [\"vx\"]\nvectors = ", "e.toml:25", "names \"vx\" twice"},
              });
}

}  // namespace
}  // namespace nlo::trainer
