// SPDX-License-Identifier: MIT
#include "trainer/plants/simulate.h"
#include "trainer/plants/run_range.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/support/thrown_message.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/shipped.h"
#include "trainer/plants/initial_states.h"
#include "trainer/plants/linear.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/simulate_runs.h"

namespace nlo::trainer {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

SimulationConfig box(double half_width, double horizon_s) {
  SimulationConfig config;
  config.initial_low = {-half_width, -half_width};
  config.initial_high = {half_width, half_width};
  config.horizon_s = horizon_s;
  return config;
}

std::unique_ptr<Plant> named(const std::string& model) {
  PlantConfig config;
  config.model = model;
  return make_plant(config);
}

TEST(Simulate, HasBothEndsOfTheHorizon) {
  SimulationConfig config = box(1.0, 50.0);
  EXPECT_EQ(sample_count(config), 2501);
  config.sample_period_s = 0.3;  // not a whole number of periods: the last sample lies before the horizon
  config.horizon_s = 1.0;
  EXPECT_EQ(sample_count(config), 4);
}

TEST(Simulate, DescribesItsSamples) {
  const auto plant = named("van_der_pol");
  const Dataset d = simulate(*plant, box(1.0, 2.0), 1, 3);
  ASSERT_EQ(d.trajectories.size(), 3u);
  EXPECT_TRUE(d.uniform);
  EXPECT_EQ(d.sample_period_s, 0.02);
  for (const Trajectory& run : d.trajectories) {
    ASSERT_EQ(run.samples(), 101);
    EXPECT_EQ(run.time_s(100), 100 * 0.02);
    EXPECT_EQ(run.outputs, run.states.topRows(1));
    EXPECT_TRUE((run.weight.array() == 1.0).all());
  }
}

TEST(Simulate, SettlesOnTheVanDerPolLimitCycle) {
  // Amplitude and period for mu = 1 from Andersen & Geer, "Power series expansions for the frequency and period of the
  // limit cycle of the van der Pol equation" (1982): 2.00862, 6.66329.
  const auto plant = named("van_der_pol");
  SimulationConfig config = box(1.0, 100.0);
  config.sample_period_s = 0.005;
  const Dataset d = simulate_from(*plant, config, Eigen::Vector2d(0.1, 0.0));
  const Eigen::VectorXd x1 = d.trajectories[0].states.row(0).tail(10000);  // the last 50 s, after the transient
  EXPECT_NEAR(x1.maxCoeff(), 2.00862, 3e-5);  // a peak missed by half a sample: curvature 2 x (h / 2)^2 / 2 = 6e-6
  std::vector<double> crossings;
  for (Eigen::Index k = 1; k < x1.size(); ++k)
    if (x1(k - 1) < 0.0 && x1(k) >= 0.0)
      crossings.push_back(config.sample_period_s * (static_cast<double>(k) - x1(k) / (x1(k) - x1(k - 1))));
  ASSERT_GT(crossings.size(), 4u);
  const double period = (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
  EXPECT_NEAR(period, 6.66329, 2e-5);
}

TEST(Simulate, ConservesTheEnergyOfTheReverseDuffing) {
  const auto plant = named("reverse_duffing");
  const Dataset d = simulate(*plant, box(1.0, 50.0), 5, 20);
  for (const Trajectory& run : d.trajectories) {
    const Eigen::ArrayXd energy = 2.0 * run.states.row(0).array().square() + run.states.row(1).array().pow(4);
    EXPECT_LE((energy - energy(0)).abs().maxCoeff(), 1e-6 * (1.0 + energy(0)));  // drift of RK4 over 50 s at 0.02 s
  }
}

TEST(Simulate, FollowsTheExactSolutionOfALinearPlant) {
  const auto plant = named("harmonic_oscillator");
  const Dataset d = simulate_from(*plant, box(1.0, 10.0), Eigen::Vector2d(1.0, 0.0));
  const Trajectory& run = d.trajectories[0];
  // Phase error of RK4 per unit time: omega (omega h)^4 / 120 = 1.3e-9.
  EXPECT_LE((run.states.row(0).transpose().array() - run.time_s.array().cos()).abs().maxCoeff(), 1.5e-8);
}

TEST(Simulate, GivesTheSameBytesForTheSameSeed) {
  const auto plant = named("sine_cosine");
  const Dataset a = simulate(*plant, box(5.0, 5.0), 9, 4), b = simulate(*plant, box(5.0, 5.0), 9, 4);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(a.trajectories[i].states, b.trajectories[i].states);
}

TEST(Simulate, NamesThePlantAndTheInitialStateOfADivergence) {
  PlantConfig config;
  config.states = {"x1", "x2"};
  config.derivative = {"x1^2", "0"};  // escapes at 1 / x1(0)
  config.outputs = {"x1"};
  const auto plant = make_plant(config);
  const std::string message = thrown_message([&] {
    Eigen::MatrixXd initial(2, 2);
    initial << -1.0, 1.5, 0.25, 0.25;
    simulate_from(*plant, box(2.0, 5.0), initial);
  });
  EXPECT_THAT(message, HasSubstr("x(0) = (1.5, 0.25)"));
  EXPECT_THAT(message, HasSubstr("t = 0.7 s"));  // it escapes at 2/3 s; RK4 overflows one or two steps later
}

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

TEST(RangeWarnings, NameStateTimeAndRemedyForRunsThatLeaveTheirBox) {
  // exp(.4 t) is ten times its initial value after 5.76 s; no state of the box is beyond 10 m before that.
  const auto found = warnings(kLine, {"plant.parameters.a=0.4"}, 50);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_THAT(found[0], AllOf(HasSubstr("height starts between -1 and 1 m, but "),
                              HasSubstr(" of 50 runs go beyond ten half widths of that box"),
                              HasSubstr("the first at t = 5."), HasSubstr("at t = 10 s of simulation "),
                              HasSubstr("still growing"), HasSubstr("[feedback]"), HasSubstr("horizon_s (now 10)")));
}

TEST(RangeWarnings, NameUnboundedGrowthBeforeItIsLarge) {
  // exp(.2 t): 2.7 half widths at half of the horizon, 7.4 at its end.
  const auto found = warnings(kLine, {"plant.parameters.a=0.2"}, 50);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_THAT(found[0], HasSubstr("height starts between -1 and 1 m and grows without bound"));
  EXPECT_THAT(warnings(kLine, {"plant.parameters.a=0.2", "simulation.horizon_s=5"}, 50), IsEmpty())
      << "the remedy that it names works";
  EXPECT_THAT(warnings(kLine, {"plant.parameters.b=0.5"}), IsEmpty())
      << "control: from 3.5 to 6 half widths is not unbounded growth";
}

TEST(RangeWarnings, ProposeWrapsForAnEncoderInsteadOfAShorterHorizon) {
  const std::string encoder = R"(
name = "encoder"
[plant]
states = ["angle", "omega"]
derivative = ["omega", "0"]
outputs = ["angle"]
estimated = ["omega"]
[simulation]
horizon_s = 2.0
sample_period_s = 0.01
trajectories = 8
initial_low = [-3, -200]
initial_high = [3, 200]
[observer]
eigenvalues = [-3.0, -5.0]
)";
  for (const bool relative : {true, false}) {
    const std::vector<std::string> changes = {
        relative ? "observer.features=\"latent_minus_output\"" : "observer.features=\"latent\"",
        "observer.output_injection=\"unit_gain\""};
    const auto found = warnings(encoder, changes);
    ASSERT_THAT(found, SizeIs(1));
    EXPECT_THAT(found[0], AllOf(HasSubstr("angle starts between -3 and 3"), HasSubstr("output_wraps"),
                                Not(HasSubstr("a shorter [simulation]"))));
    EXPECT_EQ(found[0].find("and its output is relative") != std::string::npos, relative) << found[0];
  }
}

TEST(RangeWarnings, DoNotAppearForPlantsThatSettleSwingOrTurn) {
  EXPECT_THAT(warnings(kLine), IsEmpty());
  EXPECT_THAT(warnings(kLine, {"plant.parameters.a=-1", "plant.parameters.b=9"}), IsEmpty()) << "settles at 9";
  EXPECT_THAT(warnings(kLine, {"plant.parameters.b=9", "plant.state_wraps=[\"2pi\"]", "plant.output_wraps=[\"2pi\"]",
                               "plant.state_encodings=[\"sincos\"]", "plant.output_encodings=[\"sincos\"]"}),
              IsEmpty())
      << "an angle may turn";
  // Control: the same drift without a wrap.
  EXPECT_THAT(warnings(kLine, {"plant.parameters.b=9"}), SizeIs(1));
}

TEST(RangeWarnings, NameAFeedbackThatDoesNotHoldThePlant) {
  const std::string loop =
      kLine + "[feedback]\nlaw = [\"-1.5*height\"]\nactuator_low = [-0.1]\nactuator_high = [0.1]\n";
  const std::vector<std::string> unstable = {"plant.parameters.a=0.8"};
  const auto found = warnings(loop, unstable);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_THAT(found[0], HasSubstr("its [feedback] does not stabilise it"));
  EXPECT_THAT(warnings(loop, {"plant.parameters.a=0.8", "feedback.actuator_low=[-9]", "feedback.actuator_high=[9]"}),
              IsEmpty());
}

/// Shipped plants whose range is much larger than their initial states: spikes of an attractor, an epidemic, a ship
/// that moves away.
TEST(RangeWarnings, AppearForThreeShippedExperiments) {
  std::set<std::string> found;
  for (const ShippedExperiment& shipped : shipped_experiments()) {
    const Experiment e = parse_experiment(shipped.text, std::string(shipped.name) + ".toml");
    if (e.plant && !warnings(std::string(shipped.text)).empty()) found.emplace(shipped.name);
  }
  EXPECT_THAT(found, testing::ElementsAre("plants/bearings_only", "plants/roessler", "plants/sir"));
}

}  // namespace
}  // namespace nlo::trainer
