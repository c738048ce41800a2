// SPDX-License-Identifier: MIT
// Errors in experiments with a plant: angles, initial states, noises, random inputs, parameters and process noise, and
// [feedback]. Each row breaks an experiment in one place.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/experiments/experiment_text.h"

namespace nlo::trainer {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

/// A pendulum that can turn over and whose angle is measured.
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

TEST(PlantErrors, NameWrongAngles) {
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
          {"estimated = [\"omega\"]\n", "", "e.toml:7", "so it cannot estimate theta; leave theta out of `estimated`"},
          {"[observer]", "[loss]\nmap_consistency = 1\n[observer]", "e.toml:9", "T(x) is a function of all states"},
      });
  const std::string sincos = with(with(kPendulum, "estimated = [\"omega\"]",
                                       "state_encodings = [\"sincos\", \"unwrap\"]\noutput_encodings = [\"sincos\"]"),
                                  "\"latent_minus_output\"", "\"latent_and_output\"");
  EXPECT_EQ(error_of(sincos), "no error");
  EXPECT_EQ(error_of(with(sincos, "[observer]", "[loss]\nmap_consistency = 1\n[observer]")), "no error");
  const std::string mirrored = with(sincos, "[observer]", "[training]\nmirror = true\n[observer]");
  EXPECT_EQ(error_of(mirrored), "no error") << "the sine changes its sign, the cosine does not";
  expect_rows(mirrored, {{"outputs = [\"theta\"]", "outputs = [\"theta\"]\neven = [\"thet\"]", "e.toml:7",
                          "not a state, output or input; did you mean \"theta\"?"},
                         {"outputs = [\"theta\"]", "outputs = [\"theta\"]\neven = [\"theta\"]", "e.toml:18",
                          "and at the mirror image x = ("}});
  const std::string driven = with(sincos, "outputs = [\"theta\"]",
                                  "outputs = [\"theta\"]\ninputs = [\"u\"]\ninput_field = [[\"0\"], [\"1\"]]");
  expect_rows(with(driven, "[observer]", "[loss]\nmap_consistency = 1\n[observer]"),
              {{"eigenvalues", "structure = \"driven_kkl\"\neigenvalues", "e.toml:3", "the plant's own states"}});
}

TEST(PlantErrors, NameWrongInitialStates) {
  const std::string corners = "initial_low = [-1, -1]\ninitial_high = [1, 1]";
  const auto with_start = [&](const std::string& start) { return with(kPlantExperiment, corners, start); };
  for (const char* start :
       {"initial_low = [-1, 2]\ninitial_high = [1, 2]", "initial_low = [2, 2]\ninitial_high = [2, 2]",
        "initial_distribution = \"circle\"\ninitial_axes = [[2, 0], [0, 2]]",
        "initial_distribution = \"circle\"\ninitial_axes = [[2, 0], [0, 2]]\ninitial_centre = [1, 1]",
        "initial_distribution = \"list\"\ninitial_states = [[1, 2]]"})
    EXPECT_EQ(error_of(with_start(start)), "no error") << start;
  expect_rows(
      kPlantExperiment,
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
           "initial_states has no effect with initial_distribution = \"uniform\""},
          {"[-1, -1]", "[-1, -1]\ninitial_distribution = \"list\"", "e.toml:10", "initial_low has no effect with"},
      });
}

TEST(PlantErrors, NameWrongNoisesOfOutputs) {
  const std::string two = with(with(kPlantExperiment, "model = \"van_der_pol\"\nparameters = { mu = 1.5 }",
                                    "states = [\"a\", \"b\"]\nderivative = [\"b\", \"-a\"]\noutputs = [\"a\", \"b\"]"),
                               "\"gaussian:0.5\"", "[\"gaussian:0.5\", \"none\"]");
  const Experiment once = parse_experiment(two, "e.toml");
  EXPECT_EQ(once.training.noise, parse_noise("gaussian:0.5,none"));
  EXPECT_EQ(parse_experiment(once.source_text, "source_text").training.noise, once.training.noise);
  expect_rows(kPlantExperiment,
              {
                  {"\"gaussian:0.5\"", "[\"gaussian:0.5\", \"none\"]", "e.toml:20", "is for 2 outputs, but there is 1"},
                  {"\"gaussian:0.5\"", "[\"gaussian:0.5\", \"nothing\"]", "e.toml:20", "noise[1]: noise \"nothing\""},
                  {"\"gaussian:0.5\"", "[[\"gaussian:0.5\"]]", "e.toml:20", "it must be the noise of one output"},
                  {"\"gaussian:0.5\"", "[\"none,none\"]", "e.toml:20", "it must be the noise of one output"},
                  {"\"gaussian:0.5\"", "[]", "e.toml:20", "one noise for each output"},
              });
}

/// A function, because a constant that depends on a constant of another file might be initialised before that one.
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

TEST(Excitation, ReadsBackFromItsTextAndIsOnlyWrittenIfGiven) {
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

TEST(Excitation, NeedsOnlyTheRanges) {
  const Experiment e = parse_experiment(kPlantExperiment, "e.toml", {"excitation.low=[-1]", "excitation.high=[2]"});
  ASSERT_TRUE(e.excitation);
  EXPECT_EQ(e.excitation->kinds.size(), 8u) << "all kinds except zero";
  EXPECT_EQ(parse_experiment(e.source_text, "again").source_text, e.source_text);
}

TEST(ExcitationErrors, NameTheKeyAndTheRemedy) {
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
          {"[0.1, 0.5]", "[0.1]", "e.toml:25", "amplitude has 1 numbers; give [smallest, largest]"},
          {"[0.1, 0.5]", "[0.5, 0.1]", "e.toml:25", "amplitude is [0.5, 0.1]"},
          {"[0.1, 0.5]", "[0.5, 1.5]", "e.toml:25", "amplitude[1] is 1.5; the range of u allows at most 1"},
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
          {"shortest_s = 0.5", "log = \"u.csv\"", "e.toml:26", "log is only used for the kind \"log\""},
          {"steps = 10", "transient = \"backward\"", "e.toml:19", "but there is [excitation]; use \"drop\""},
      });
  EXPECT_THAT(error_of(kLogExperiment + "[excitation]\nlow = [-1]\nhigh = [1]\n"),
              HasSubstr("[excitation] is not used with [log] alone"));
}

TEST(ExcitationErrors, AskForProcessNoiseOfEachState) {
  const auto with_noise = [](const std::string& noise) {
    return with(kPlantExperiment, "trajectories = 4", "trajectories = 4\nprocess_noise = " + noise);
  };
  EXPECT_EQ(error_of(with_noise("[0, 0.1]")), "no error");
  EXPECT_THAT(error_of(with_noise("[0.1]")), StartsWith("e.toml:10: [simulation] process_noise has 1 numbers"));
  EXPECT_THAT(error_of(with_noise("[0.1, -0.1]")), StartsWith("e.toml:10: [simulation] process_noise[1] is -0.1"));
  EXPECT_THAT(error_of(with(with_noise("[0, 0.1]"), "steps = 10", "transient = \"backward\"")),
              HasSubstr("but there is [simulation] process_noise"));
  EXPECT_EQ(error_of(with_noise("[0, 0.1]\nprocess_noise_share = 0.5")), "no error");
  EXPECT_THAT(error_of(with_noise("[0, 0.1]\nprocess_noise_share = 1.5")),
              StartsWith("e.toml:11: [simulation] process_noise_share is 1.5"));
  EXPECT_THAT(error_of(with(kPlantExperiment, "trajectories = 4", "trajectories = 4\nprocess_noise_share = 0.5")),
              StartsWith("e.toml:10: [simulation] process_noise_share has no effect without process_noise; give"));
  const Experiment once = parse_experiment(with_noise("[0, 0.1]"), "e.toml");
  EXPECT_THAT(parse_experiment(once.source_text, "again").simulation.process_noise, ElementsAre(0.0, 0.1));
}

TEST(ExcitationErrors, NameWrongRangesOfParameters) {
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
              HasSubstr("but there is [plant] parameters with a range"));
}

TEST(ExcitationErrors, NameAnInputWithoutEffect) {
  const std::string text = with(kPlantExperiment, "model = \"van_der_pol\"\nparameters = { mu = 1.5 }",
                                "states = [\"a\", \"b\"]\nderivative = [\"b\", \"-a + sin(u)\"]\noutputs = [\"a\"]\n"
                                "inputs = [\"u\"]");
  EXPECT_EQ(error_of(text), "no error");
  const Experiment once = parse_experiment(text, "e.toml");
  EXPECT_EQ(parse_experiment(once.source_text, "again").source_text, once.source_text);
  expect_rows(text, {
                        {"sin(u)", "sin(v)", "e.toml:5", "derivative[1] \"-a + sin(v)\""},
                        {"sin(u)", "sin(a)", "e.toml:7", "the input \"u\" has no effect; name it in a derivative"},
                        {"outputs = [\"a\"]", "outputs = [\"a + u\"]", "e.toml:6", "a function of the state alone"},
                        {"inputs = [\"u\"]", "inputs = [\"u\"]\ninput_field = [[\"0\"], [\"1\"]]", "e.toml:5",
                         "write inputs in input_field, or remove input_field and name the inputs here"},
                    });
}

/// A function, because a constant that depends on a constant of another file might be initialised before that one.
std::string closed() {
  return kPlantExperiment + R"([feedback]
law = ["-x1 - mu*x2 + r_u"]
actuator_low = [-1]
actuator_high = [2]
error = [0.1, 0.2]
rounds = 2
)";
}

TEST(Feedback, ReadsBackFromItsTextAndIsOnlyWrittenIfGiven) {
  const Experiment once = parse_experiment(closed(), "e.toml");
  ASSERT_TRUE(once.feedback);
  EXPECT_THAT(once.feedback->error, ElementsAre(0.1, 0.2));
  EXPECT_EQ(once.feedback->rounds, 2);
  EXPECT_EQ(once.feedback->share, 1.0);
  EXPECT_EQ(parse_experiment(once.source_text, "again").source_text, once.source_text);
  EXPECT_THAT(parse_experiment(kPlantExperiment, "e.toml").source_text, Not(HasSubstr("[feedback]")));
}

TEST(FeedbackErrors, NameTheKeyAndTheRemedy) {
  ASSERT_EQ(error_of(closed()), "no error");
  expect_rows(closed(),
              {
                  {"mu*x2", "mu*x3", "e.toml:22", "[feedback] law[0] \"-x1 - mu*x3 + r_u\""},
                  {"r_u", "r_v", "e.toml:22", "variables: x1, x2, r_u"},
                  {"law = [\"-x1 - mu*x2 + r_u\"]\n", "", "e.toml:21", "has 0 laws, but the plant has 1 inputs"},
                  {"r_u\"]", "r_u\", \"0\"]", "e.toml:22", "law has 2 laws, but the plant has 1 inputs"},
                  {"actuator_low = [-1]\n", "", "e.toml:21", "[feedback] has no actuator_low"},
                  {"actuator_high = [2]\n", "", "e.toml:21", "[feedback] has no actuator_high"},
                  {"actuator_high = [2]", "actuator_high = [-1]", "e.toml:24", "it must be above actuator_low[0], -1"},
                  {"[0.1, 0.2]", "[0.1]", "e.toml:25", "error has 1 numbers, but the plant has 2 states"},
                  {"[0.1, 0.2]", "[0.1, -0.2]", "e.toml:25", "error[1] is -0.2"},
                  {"rounds = 2", "rounds = -1", "e.toml:26", "rounds is -1"},
                  {"rounds = 2", "rounds = 2\nshare = 1.5", "e.toml:27", "share is 1.5"},
                  {"rounds = 2", "rounds = 2\ncost = \"x1^2 + r_u\"", "e.toml:27", "variables: x1, x2, u"},
                  {"rounds = 2", "round = 2", "e.toml:26", "did you mean \"rounds\"?"},
                  {"hold = \"first_order\"", "input_hold = \"first_order\"", "e.toml:16", "use \"zero_order\""},
                  {"parameters = { mu = 1.5 }", "parameters = { mu = 1.5 }\nestimated = [\"x1\"]", "e.toml:23",
                   "law[0] \"-x1 - mu*x2 + r_u\" reads x2, which the observer does not estimate"},
                  {"\"van_der_pol\"\nparameters = { mu = 1.5 }", "\"sine_cosine\"", "e.toml:20",
                   "the plant sine_cosine has none"},
                  {"steps = 10", "transient = \"backward\"", "e.toml:19", "there is [feedback]; use \"drop\""},
              });
  EXPECT_THAT(error_of(kLogExperiment + "[feedback]\nlaw = [\"0\"]\n"), HasSubstr("the data are recorded logs"));
}

}  // namespace
}  // namespace nlo::trainer
