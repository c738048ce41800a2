// SPDX-License-Identifier: MIT
// [feedback]: each row breaks an experiment in one place.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/experiments/experiment_text.h"

namespace nlo::trainer {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

/// A function: a constant made of another's text could be made before it.
std::string closed() {
  return kPlantExperiment + R"([feedback]
law = ["-x1 - mu*x2 + r_u"]
actuator_low = [-1]
actuator_high = [2]
error = [0.1, 0.2]
rounds = 2
)";
}

TEST(Feedback, ReadsBackFromItsTextAndIsNotWrittenWhenNotGiven) {
  const Experiment once = parse_experiment(closed(), "e.toml");
  ASSERT_TRUE(once.feedback);
  EXPECT_THAT(once.feedback->error, ElementsAre(0.1, 0.2));
  EXPECT_EQ(once.feedback->rounds, 2);
  EXPECT_EQ(once.feedback->share, 1.0);
  EXPECT_EQ(parse_experiment(once.source_text, "again").source_text, once.source_text);
  EXPECT_THAT(parse_experiment(kPlantExperiment, "e.toml").source_text, Not(HasSubstr("[feedback]")));
}

TEST(FeedbackErrors, NameTheKeyAndTheMend) {
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
  EXPECT_THAT(error_of(kLogExperiment + "[feedback]\nlaw = [\"0\"]\n"), HasSubstr("logs are as they were recorded"));
}

}  // namespace
}  // namespace nlo::trainer
