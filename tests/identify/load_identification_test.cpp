// SPDX-License-Identifier: MIT
#include "trainer/experiments/load_identification.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codegen/base/error.h"
#include "tests/identify/identified_pendulum.h"

namespace nlo::trainer {
namespace {

struct Mistake {
  const char *old, *replacement, *message;
};

class MistakenIdentification : public testing::TestWithParam<Mistake> {};

TEST_P(MistakenIdentification, IsRefusedWithPlaceAndMend) {
  const auto& [old, replacement, message] = GetParam();
  std::string text = test::kPendulumIdentification;
  const auto at = text.find(old);
  ASSERT_NE(at, std::string::npos) << old;
  text.replace(at, std::string(old).size(), replacement);
  EXPECT_THAT([&] { parse_identification(text, "f.toml"); },
              testing::ThrowsMessage<codegen::Error>(testing::HasSubstr(message)));
}

INSTANTIATE_TEST_SUITE_P(
    Mistakes, MistakenIdentification,
    testing::Values(
        Mistake{"w2 * sin", "w3 * sin",
                "f.toml:6: [plant] derivative[1] \"-w3 * sin(angle) - c * rate + u\": Unexpected token \"w3\""},
        Mistake{"c = 1.0", "c = 1.0, d = 2.0", "f.toml:9: [plant] the parameter \"d\" acts nowhere"},
        Mistake{"c * rate + u", "c * rate", "f.toml:5: [plant] the input \"u\" acts nowhere"},
        Mistake{"positive = [\"w2\"]", "positive = [\"w\"]",
                "[identify] positive \"w\" is not a parameter of the plant; did you mean \"w2\"?"},
        Mistake{"noise = { angle", "noise = { angel",
                "neither an output of the plant nor a logged state; did you mean \"angle\"?"},
        Mistake{"noise = { angle = 0.01 }", "noise = { rate = 0.1 }", "says nothing of the output \"angle\""},
        Mistake{"noise = { angle = 0.01", "noise = { angle = 0.0", "[identify] noise.angle"},
        Mistake{"output_names = [\"angle\"]", "output_names = [\"angl\"]",
                "[plant] output \"angl\" is not a column of the logs with role \"output\"; did you mean \"angle\"?"},
        Mistake{"name = \"rate\"", "name = \"speed\"", "[[log.columns]] state \"speed\" is not a state of the plant"},
        Mistake{"initial_deviation = [1.0, 5.0]", "initial_deviation = [1.0]",
                "f.toml:15: [identify] initial_deviation has 1 numbers; the plant has 2 states"},
        Mistake{"segment_s", "segments_s", "unknown key \"segments_s\" in [identify]; did you mean \"segment_s\"?"},
        Mistake{"outputs = [\"angle\"]\n", "outputs = [\"angle\"]\nstate_wraps = [\"2pi\", 0]\n",
                "[plant] state_wraps has no use here"},
        Mistake{"w2 = 15.0", "w2 = -15.0", "[identify] positive keeps it above 0"},
        Mistake{"[identify]", "[observer]",
                "unknown key \"observer\" in the identification; there are: name, threads, plant, log, identify"}));

TEST(Identification, TheOneThatTheMistakesAreMadeInIsRight) {
  const Identification pendulum = test::pendulum_identification();  // the control of all of them
  EXPECT_EQ(pendulum.plant.parameters.size(), 2u);
  EXPECT_EQ(pendulum.identify.segment_s, 2.0);
  EXPECT_EQ(test::pendulum_identification({"identify.segment_s=0.5"}).identify.segment_s, 0.5);
}

TEST(Identification, NeedsItsSections) {
  const std::string text = test::kPendulumIdentification;
  EXPECT_THAT([&] { parse_identification(text.substr(0, text.find("[identify]")), "f.toml"); },
              testing::ThrowsMessage<codegen::Error>(testing::HasSubstr("there is no [log]")));
}

TEST(Identification, EveryShippedOneReads) {
  EXPECT_GE(shipped_identifications().size(), 6u);
  for (const ShippedExperiment& shipped : shipped_identifications())
    EXPECT_EQ(parse_identification(shipped.text, std::string(shipped.name)).name, shipped.name);
}

}  // namespace
}  // namespace nlo::trainer
