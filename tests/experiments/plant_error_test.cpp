// SPDX-License-Identifier: MIT
// Angles, initial states and noises of plants: each row breaks an experiment in one place.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/experiments/experiment_text.h"

namespace nlo::trainer {
namespace {

/// A pendulum that turns over, its angle measured.
const std::string kPendulum = R"toml(name = "pendulum"

[plant]
states = ["theta", "omega"]
derivative = ["omega", "-9.81*sin(theta)"]
outputs = ["theta"]
state_wraps = ["2pi", 0]
output_wraps = ["2pi"]
estimated = ["omega"]

[simulation]
initial_low = [-3, -9]
initial_high = [3, 9]

[observer]
eigenvalues = [-10.0]
output_injection = "unit_gain"
start = "steady"
features = "latent_minus_output"
)toml";

TEST(PlantErrors, AnglesOfPlants) {
  ASSERT_EQ(error_of(kPendulum), "no error");
  const Experiment once = parse_experiment(kPendulum, "e.toml");
  EXPECT_EQ(once.plant->state_wraps, (std::vector<double>{6.283185307179586, 0.0}));
  EXPECT_EQ(parse_experiment(once.source_text, "source_text").source_text, once.source_text);
  expect_rows(
      kPendulum,
      {
          {"[\"2pi\", 0]", "[\"pi\", 0]", "e.toml:7", "state_wraps[0] is \"pi\"; it must be a number"},
          {"[\"2pi\", 0]", "[\"2pi\"]", "e.toml:7", "state_wraps has 1 entries, but there are 2 states"},
          {"output_wraps = [\"2pi\"]", "output_encodings = [\"sincos\"]", "e.toml:8", "y is not an angle"},
          {"estimated = [\"omega\"]", "estimated = [\"rate\"]", "e.toml:9", "\"rate\", which is not a state"},
          {"\"latent_minus_output\"", "\"latent\"", "e.toml:19",
           "the output y is an unwrapped angle; set features = \"latent_minus_output\", or its [plant] "
           "output_encodings"},
          {"\"unit_gain\"", "\"ones\"", "e.toml:17", "set output_injection = \"unit_gain\""},
          {"\"steady\"", "\"zero\"", "e.toml:18", "set start = \"steady\""},
          {"estimated = [\"omega\"]\n", "", "e.toml:7", "cannot give theta itself; leave theta out of `estimated`"},
          {"[observer]", "[loss]\nmap_consistency = 1\n[observer]", "e.toml:9", "T(x) is a function of all of them"},
      });
  const std::string sincos = with(with(kPendulum, "estimated = [\"omega\"]",
                                       "state_encodings = [\"sincos\", \"unwrap\"]\noutput_encodings = [\"sincos\"]"),
                                  "\"latent_minus_output\"", "\"latent_and_output\"");
  EXPECT_EQ(error_of(sincos), "no error");
  EXPECT_EQ(error_of(with(sincos, "[observer]", "[loss]\nmap_consistency = 1\n[observer]")), "no error");
  const std::string mirrored = with(sincos, "[observer]", "[training]\nmirror = true\n[observer]");
  EXPECT_EQ(error_of(mirrored), "no error") << "the sine turns, the cosine stays";
  expect_rows(mirrored, {{"outputs = [\"theta\"]", "outputs = [\"theta\"]\neven = [\"thet\"]", "e.toml:7",
                          "not a state, output or input; did you mean \"theta\"?"},
                         {"outputs = [\"theta\"]", "outputs = [\"theta\"]\neven = [\"theta\"]", "e.toml:18",
                          "and at its mirror image it is"}});
  const std::string driven = with(sincos, "outputs = [\"theta\"]",
                                  "outputs = [\"theta\"]\ninputs = [\"u\"]\ninput_field = [[\"0\"], [\"1\"]]");
  expect_rows(with(driven, "[observer]", "[loss]\nmap_consistency = 1\n[observer]"),
              {{"eigenvalues", "structure = \"driven_kkl\"\neigenvalues", "e.toml:3", "the plant's own states"}});
}

TEST(PlantErrors, InitialStates) {
  const std::string corners = "initial_low = [-1, -1]\ninitial_high = [1, 1]";
  const auto with_start = [&](const std::string& start) { return with(kPlantExperiment, corners, start); };
  for (const char* start :
       {"initial_low = [-1, 2]\ninitial_high = [1, 2]", "initial_low = [2, 2]\ninitial_high = [2, 2]",
        "initial_distribution = \"circle\"\ninitial_axes = [[2, 0], [0, 2]]",
        "initial_distribution = \"circle\"\ninitial_axes = [[2, 0], [0, 2]]\ninitial_centre = [1, 1]",
        "initial_distribution = \"list\"\ninitial_states = [[1, 2]]"})
    EXPECT_EQ(error_of(with_start(start)), "no error") << start;
  expect_rows(kPlantExperiment,
              {
                  {corners, "initial_distribution = \"circle\"", "e.toml:7", "initial_axes has 0 half axes"},
                  {corners, "initial_distribution = \"circle\"\ninitial_axes = [[2, 0], [2]]", "e.toml:11",
                   "initial_axes[1] has 1 numbers; the plant has 2 states"},
                  {corners, "initial_distribution = \"circle\"\ninitial_axes = [[2, 0], [0, 2]]\ninitial_centre = [0]",
                   "e.toml:12", "initial_centre has 1 numbers"},
                  {corners, "initial_distribution = \"list\"", "e.toml:7", "initial_states is empty"},
                  {corners, "initial_distribution = \"list\"\ninitial_states = [[1, 2], [3]]", "e.toml:11",
                   "initial_states[1] has 1 numbers"},
                  {corners, "initial_distribution = \"point\"", "e.toml:10", "use \"uniform\""},
                  {"[-1, -1]", "[-1, -1]\ninitial_states = [[0, 0]]", "e.toml:11",
                   "initial_states has no use for initial_distribution = \"uniform\""},
                  {"[-1, -1]", "[-1, -1]\ninitial_distribution = \"list\"", "e.toml:10", "initial_low has no use"},
              });
}

TEST(PlantErrors, NoisePerOutput) {
  const std::string two = with(with(kPlantExperiment, "model = \"van_der_pol\"\nparameters = { mu = 1.5 }",
                                    "states = [\"a\", \"b\"]\nderivative = [\"b\", \"-a\"]\noutputs = [\"a\", \"b\"]"),
                               "\"gaussian:0.5\"", "[\"gaussian:0.5\", \"none\"]");
  const Experiment once = parse_experiment(two, "e.toml");
  EXPECT_EQ(once.training.noise, parse_noise("gaussian:0.5,none"));
  EXPECT_EQ(parse_experiment(once.source_text, "source_text").training.noise, once.training.noise);
  expect_rows(kPlantExperiment,
              {
                  {"\"gaussian:0.5\"", "[\"gaussian:0.5\", \"none\"]", "e.toml:20", "is of 2 outputs, but there is 1"},
                  {"\"gaussian:0.5\"", "[\"gaussian:0.5\", \"nothing\"]", "e.toml:20", "noise[1]: noise \"nothing\""},
                  {"\"gaussian:0.5\"", "[[\"gaussian:0.5\"]]", "e.toml:20", "it must be the noise of one output"},
                  {"\"gaussian:0.5\"", "[\"none,none\"]", "e.toml:20", "it must be the noise of one output"},
                  {"\"gaussian:0.5\"", "[]", "e.toml:20", "one noise for each output"},
              });
}

}  // namespace
}  // namespace nlo::trainer
