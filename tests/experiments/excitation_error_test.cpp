// SPDX-License-Identifier: MIT
// What is drawn for each run of a plant: inputs, parameters, process noise. Each row breaks an experiment in one place.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/experiments/experiment_text.h"

namespace nlo::trainer {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

/// A function: a constant made of another's text could be made before it.
std::string excited() {
  return kPlantExperiment + R"([excitation]
kinds = ["steps", "zero", "multisine"]
low = [-1]
high = [1]
amplitude = [0.1, 0.5]
shortest_s = 0.5
longest_s = 4
)";
}

TEST(Excitation, ReadsBackFromItsTextAndIsNotWrittenWhenNotGiven) {
  const Experiment once = parse_experiment(excited(), "e.toml");
  ASSERT_TRUE(once.excitation);
  EXPECT_THAT(once.excitation->kinds, ElementsAre(InputSignal::kSteps, InputSignal::kZero, InputSignal::kMultisine));
  EXPECT_THAT(once.excitation->amplitude, ElementsAre(0.1, 0.5));
  EXPECT_EQ(once.excitation->longest_s, 4.0);
  EXPECT_EQ(parse_experiment(once.source_text, "again").source_text, once.source_text);
  const std::string without = parse_experiment(kPlantExperiment, "e.toml").source_text;
  EXPECT_THAT(without, Not(HasSubstr("[excitation]")));
  EXPECT_THAT(without, Not(HasSubstr("process_noise")));
  EXPECT_THAT(without, HasSubstr("parameters = { mu = 1.5 }"));
}

TEST(Excitation, NeedsRangesAlone) {
  const Experiment e = parse_experiment(kPlantExperiment, "e.toml", {"excitation.low=[-1]", "excitation.high=[2]"});
  ASSERT_TRUE(e.excitation);
  EXPECT_EQ(e.excitation->kinds.size(), 8u) << "all but zero";
  EXPECT_EQ(parse_experiment(e.source_text, "again").source_text, e.source_text);
}

TEST(ExcitationErrors, NameTheKeyAndTheMend) {
  ASSERT_EQ(error_of(excited()), "no error");
  expect_rows(
      excited(),
      {
          {"\"steps\"", "\"stepz\"", "e.toml:22", "use \"steps\"?"},
          {"[\"steps\", \"zero\", \"multisine\"]", "[]", "e.toml:22", "[excitation] kinds is empty"},
          {"low = [-1]\n", "", "e.toml:21", "[excitation] has no low"},
          {"low = [-1]", "low = [-1, -1]", "e.toml:23", "low has 2 numbers, but the plant has 1 inputs"},
          {"high = [1]\n", "", "e.toml:21", "[excitation] has no high"},
          {"high = [1]", "high = [-2]", "e.toml:24", "high[0] is -2; it must not be below low[0], -1"},
          {"low = [-1]", "low = [0.5]", "e.toml:22", "has \"zero\", but the range of u, 0.5 .. 1, has no 0"},
          {"[0.1, 0.5]", "[0.1]", "e.toml:25", "amplitude has 1 numbers; give [least, most]"},
          {"[0.1, 0.5]", "[0.5, 0.1]", "e.toml:25", "amplitude is [0.5, 0.1]"},
          {"[0.1, 0.5]", "[0.5, 1.5]", "e.toml:25", "amplitude[1] is 1.5; about the middle of the range of u"},
          {"[0.1, 0.5]", "[-0.5, 0.5]", "e.toml:25", "amplitude[0] is -0.5"},
          {"shortest_s = 0.5", "shortest_s = 5", "e.toml:27", "longest_s is 4; it must not be below shortest_s, 5"},
          {"shortest_s = 0.5", "shortest_s = 0.001", "e.toml:26", "it must be at least sample_period_s, 0.02"},
          {"shortest_s = 0.5\nlongest_s = 4", "longest_s = 0.001", "e.toml:26", "longest_s is 0.001"},
          {"longest_s", "longest", "e.toml:27", "did you mean \"longest_s\"?"},
          {"\"van_der_pol\"\nparameters = { mu = 1.5 }", "\"sine_cosine\"", "e.toml:20",
           "the plant sine_cosine has none"},
          {"steps = 10", "input_noise = \"gaussian:0.1+jitter:0.2\"", "e.toml:19", "input_noise has jitter"},
          {"steps = 10", "input_noise = \"gaussian:0.1,none\"", "e.toml:19", "input_noise is not a noise for 1 inputs"},
          {"\"zero\"", "\"log\"", "e.toml:22", "no log is given; name the file: log = \"inputs.csv\""},
          {"shortest_s = 0.5", "log = \"u.csv\"", "e.toml:26", "log is read for the kind \"log\" alone"},
          {"steps = 10", "transient = \"backward\"", "e.toml:19", "and there is [excitation]; use \"drop\""},
      });
  EXPECT_THAT(error_of(kLogExperiment + "[excitation]\nlow = [-1]\nhigh = [1]\n"),
              HasSubstr("[excitation] has no use for [log]"));
}

TEST(ExcitationErrors, ProcessNoiseHasANumberForEachState) {
  const auto with_noise = [](const std::string& noise) {
    return with(kPlantExperiment, "trajectories = 4", "trajectories = 4\nprocess_noise = " + noise);
  };
  EXPECT_EQ(error_of(with_noise("[0, 0.1]")), "no error");
  EXPECT_THAT(error_of(with_noise("[0.1]")), StartsWith("e.toml:10: [simulation] process_noise has 1 numbers"));
  EXPECT_THAT(error_of(with_noise("[0.1, -0.1]")), StartsWith("e.toml:10: [simulation] process_noise[1] is -0.1"));
  EXPECT_THAT(error_of(with(with_noise("[0, 0.1]"), "steps = 10", "transient = \"backward\"")),
              HasSubstr("and there is [simulation] process_noise"));
  const Experiment once = parse_experiment(with_noise("[0, 0.1]"), "e.toml");
  EXPECT_THAT(parse_experiment(once.source_text, "again").simulation.process_noise, ElementsAre(0.0, 0.1));
}

TEST(ExcitationErrors, ParametersWithARange) {
  const auto with_range = [](const std::string& mu) { return with(kPlantExperiment, "mu = 1.5", "mu = " + mu); };
  const Experiment once = parse_experiment(with_range("[0.7, 1.3]"), "e.toml");
  EXPECT_DOUBLE_EQ(once.plant->parameters[0].second, 1.0);
  ASSERT_EQ(once.plant->parameter_ranges.size(), 1u);
  EXPECT_THAT(once.source_text, HasSubstr("parameters = { mu = [0.7, 1.3] }"));
  EXPECT_EQ(parse_experiment(once.source_text, "again").source_text, once.source_text);
  EXPECT_TRUE(parse_experiment(once.source_text, "fixed", {"plant.parameters.mu=1.2"}).plant->parameter_ranges.empty());
  EXPECT_THAT(error_of(with_range("[1.3, 0.7]")),
              AllOf(StartsWith("e.toml:5: [plant] parameters.mu"), HasSubstr("must not be above")));
  EXPECT_THAT(error_of(with_range("[1, 2, 3]")), HasSubstr("it has 3 numbers, and a range is [low, high]"));
  EXPECT_THAT(error_of(with_range("[1, \"2\"]")), HasSubstr("parameters.mu[1] is \"2\""));
  EXPECT_THAT(error_of(with(with_range("[0.7, 1.3]"), "steps = 10", "transient = \"backward\"")),
              HasSubstr("and there is [plant] parameters with a range"));
}

TEST(ExcitationErrors, AnInputThatActsNowhere) {
  const std::string text = with(kPlantExperiment, "model = \"van_der_pol\"\nparameters = { mu = 1.5 }",
                                "states = [\"a\", \"b\"]\nderivative = [\"b\", \"-a + sin(u)\"]\noutputs = [\"a\"]\n"
                                "inputs = [\"u\"]");
  EXPECT_EQ(error_of(text), "no error");
  const Experiment once = parse_experiment(text, "e.toml");
  EXPECT_EQ(parse_experiment(once.source_text, "again").source_text, once.source_text);
  expect_rows(text, {
                        {"sin(u)", "sin(v)", "e.toml:5", "derivative[1] \"-a + sin(v)\""},
                        {"sin(u)", "sin(a)", "e.toml:7", "the input \"u\" acts nowhere; name it in a derivative"},
                        {"outputs = [\"a\"]", "outputs = [\"a + u\"]", "e.toml:6", "a function of the state alone"},
                        {"inputs = [\"u\"]", "inputs = [\"u\"]\ninput_field = [[\"0\"], [\"1\"]]", "e.toml:5",
                         "inputs have their place in input_field, or remove it and name them here"},
                    });
}

}  // namespace
}  // namespace nlo::trainer
