// SPDX-License-Identifier: MIT
#include "trainer/plants/run_range.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/shipped.h"
#include "trainer/plants/initial_states.h"
#include "trainer/plants/registry.h"
#include "trainer/plants/simulate_runs.h"

namespace nlo::trainer {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// dx/dt = a x + b + u: exp(a t) for b = 0, a drift for a = 0.
const std::string kLine = R"(name = "line"
[plant]
states = ["height"]
state_units = ["m"]
derivative = ["a*height + b + u"]
outputs = ["height"]
output_names = ["y"]
inputs = ["u"]
parameters = { a = 0.0, b = 0.0 }
[simulation]
horizon_s = 10.0
sample_period_s = 0.05
trajectories = 8
initial_low = [-1]
initial_high = [1]
[observer]
eigenvalues = [-3.0]
)";

std::vector<std::string> warnings(const std::string& text, const std::vector<std::string>& changes = {},
                                  Eigen::Index count = 8) {
  const Experiment e = parse_experiment(text, "e.toml", changes);
  const auto plant = make_plant(*e.plant);
  return range_warnings(simulate_runs(e, *plant, initial_state_seed(e.seed, SeedStream::kTraining), count), e);
}

TEST(RangeWarnings, NameTheStateTheTimeAndTheFixOfRunsThatLeaveTheirBox) {
  // exp(.4 t) is ten times the start after 5.76 s; nothing of the box is beyond 10 m before that.
  const auto found = warnings(kLine, {"plant.parameters.a=0.4"}, 50);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_THAT(found[0],
              AllOf(HasSubstr("height starts within -1 and 1 m, and "), HasSubstr(" of 50 runs leave that box"),
                    HasSubstr("the first at t = 5."), HasSubstr("at t = 10 s of simulation "),
                    HasSubstr("still growing"), HasSubstr("[feedback]"), HasSubstr("horizon_s (now 10)")));
}

TEST(RangeWarnings, NameGrowthThatIsNotYetFar) {
  // exp(.2 t): 2.7 half widths by half of the horizon, 7.4 by its end.
  const auto found = warnings(kLine, {"plant.parameters.a=0.2"}, 50);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_THAT(found[0], HasSubstr("height starts within -1 and 1 m and grows without bound"));
  EXPECT_THAT(warnings(kLine, {"plant.parameters.a=0.2", "simulation.horizon_s=5"}, 50), IsEmpty())
      << "the fix it names";
  EXPECT_THAT(warnings(kLine, {"plant.parameters.b=0.5"}), IsEmpty()) << "from 3.5 to 6 half widths is not yet growth";
}

TEST(RangeWarnings, AreSilentOfWhatSettlesSwingsOrTurns) {
  EXPECT_THAT(warnings(kLine), IsEmpty());
  EXPECT_THAT(warnings(kLine, {"plant.parameters.a=-1", "plant.parameters.b=9"}), IsEmpty()) << "settles at 9";
  EXPECT_THAT(warnings(kLine, {"plant.parameters.b=9", "plant.state_wraps=[\"2pi\"]", "plant.output_wraps=[\"2pi\"]",
                               "plant.state_encodings=[\"sincos\"]", "plant.output_encodings=[\"sincos\"]"}),
              IsEmpty())
      << "an angle may turn";
  // Control: the same drift without a wrap.
  EXPECT_THAT(warnings(kLine, {"plant.parameters.b=9"}), SizeIs(1));
}

TEST(RangeWarnings, SayThatAFeedbackDoesNotHoldThePlant) {
  const std::string loop =
      kLine + "[feedback]\nlaw = [\"-1.5*height\"]\nactuator_low = [-0.1]\nactuator_high = [0.1]\n";
  const std::vector<std::string> unstable = {"plant.parameters.a=0.8"};
  const auto found = warnings(loop, unstable);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_THAT(found[0], HasSubstr("its [feedback] does not hold it"));
  EXPECT_THAT(warnings(loop, {"plant.parameters.a=0.8", "feedback.actuator_low=[-9]", "feedback.actuator_high=[9]"}),
              IsEmpty());
}

/// Shipped plants whose range is wider than any start: spikes of an attractor, an epidemic, a ship that sails away.
TEST(RangeWarnings, AreOfThreeShippedExperimentsThatMeanIt) {
  std::set<std::string> found;
  for (const ShippedExperiment& shipped : shipped_experiments()) {
    const Experiment e = parse_experiment(shipped.text, std::string(shipped.name) + ".toml");
    if (e.plant && !warnings(std::string(shipped.text)).empty()) found.emplace(shipped.name);
  }
  EXPECT_THAT(found, testing::ElementsAre("plants/bearings_only", "plants/roessler", "plants/sir"));
}

}  // namespace
}  // namespace nlo::trainer
