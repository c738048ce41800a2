// SPDX-License-Identifier: MIT
#include "trainer/plants/simulate_runs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/training_sets.h"
#include "trainer/plants/initial_states.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/simulate.h"

namespace nlo::trainer {
namespace {

constexpr double kRate = 2.0, kGain = 3.0, kStep = 0.02;

/// dx/dt = -a x + b u, y = x.
const std::string kLag = R"(name = "lag"
[plant]
states = ["x"]
derivative = ["-a*x + b*u"]
outputs = ["x"]
inputs = ["u"]
parameters = { a = 2.0, b = 3.0 }
[simulation]
horizon_s = 10.0
trajectories = 12
initial_low = [-1]
initial_high = [1]
[observer]
eigenvalues = [-3.0]
)";

const std::string kExcited = kLag + "[excitation]\nlow = [-2]\nhigh = [5]\n";

Experiment experiment(const std::string& text, const std::vector<std::string>& changes = {}) {
  return parse_experiment(text, "e.toml", changes);
}

double value_of(const PlantConfig& plant, const std::string& parameter) {
  for (const auto& [name, value] : plant.parameters)
    if (name == parameter) return value;
  return std::nan("");
}

Dataset runs_of(const Experiment& e, Eigen::Index count, std::uint64_t seed = 1, const Excitation& given = {}) {
  return simulate_runs(e, *make_plant(*e.plant), initial_state_seed(seed, SeedStream::kTest), count, 1.0, given);
}

TEST(SimulateRuns, GiveTheBytesOfSimulateIfNothingIsDrawn) {
  const Experiment e = experiment(kLag);
  const auto plant = make_plant(*e.plant);
  const Dataset a = runs_of(e, 5);
  const Dataset b = simulate(*plant, e.simulation, initial_state_seed(1, SeedStream::kTest), 5);
  EXPECT_TRUE(a.inputs.empty());
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(a.trajectories[i].states, b.trajectories[i].states);
    EXPECT_EQ(a.trajectories[i].inputs.size(), 0);
  }
}

TEST(SimulateRuns, AnInputIsHeldOverThePeriodBeforeItsSample) {
  // Exact solution: x_k = phi x_{k-1} + (1 - phi) b / a u_k, phi = exp(-a h).
  const Dataset set = runs_of(experiment(kExcited), 20);
  ASSERT_EQ(set.inputs.size(), 1u);
  EXPECT_EQ(set.inputs[0].name, "u");
  const double phi = std::exp(-kRate * kStep), gain = (1.0 - phi) * kGain / kRate;
  double worst = 0.0, shifted = 0.0;
  for (const Trajectory& run : set.trajectories) {
    ASSERT_EQ(run.inputs.cols(), run.samples());
    for (Eigen::Index k = 1; k < run.samples(); ++k) {
      const double kept = phi * run.states(0, k - 1);
      worst = std::max(worst, std::abs(kept + gain * run.inputs(0, k) - run.states(0, k)));
      shifted = std::max(shifted, std::abs(kept + gain * run.inputs(0, k - 1) - run.states(0, k)));
    }
  }
  EXPECT_LT(worst, 2e-8);  // error of RK4: (a h)^5 / 120 = 9e-10 of |x| and |b u / a|, together 15
  EXPECT_GT(shifted, 1e-3) << "control: the input of the previous sample does not fit";
}

TEST(SimulateRuns, AFirstOrderHoldRampsFromSampleToSample) {
  // Exact solution: phi x + b (u0 (1 - phi) / a + (u1 - u0) / h (h / a - (1 - phi) / a^2)).
  const Dataset set = runs_of(experiment(kExcited, {"observer.input_hold=first_order"}), 20);
  const double phi = std::exp(-kRate * kStep);
  const double held = kGain * (1.0 - phi) / kRate;
  const double ramp = kGain / kStep * (kStep / kRate - (1.0 - phi) / (kRate * kRate));
  double worst = 0.0, without = 0.0;
  for (const Trajectory& run : set.trajectories)
    for (Eigen::Index k = 1; k < run.samples(); ++k) {
      const double u0 = run.inputs(0, k - 1), u1 = run.inputs(0, k);
      const double x = phi * run.states(0, k - 1) + held * u0 + ramp * (u1 - u0);
      worst = std::max(worst, std::abs(x - run.states(0, k)));
      without = std::max(without, std::abs(x - ramp * (u1 - u0) - run.states(0, k)));
    }
  EXPECT_LT(worst, 4e-7);  // error of RK4: b |u1 - u0| a^3 h^4 / 120, at most 2.2e-7, plus the 2e-8 above
  EXPECT_GT(without, 1e-3) << "control: some inputs step within a period";
  const Dataset zero_order = runs_of(experiment(kExcited), 20);
  EXPECT_EQ(zero_order.trajectories[3].inputs, set.trajectories[3].inputs) << "the same signal with two holds";
  EXPECT_NE(zero_order.trajectories[3].states, set.trajectories[3].states);
}

TEST(SimulateRuns, DependOnTheSeedAndNotOnTheNumberOfRuns) {
  const Experiment e = experiment(kExcited, {"plant.parameters.a=[1, 3]", "simulation.process_noise=[0.1]"});
  const Dataset few = runs_of(e, 3), many = runs_of(e, 6), other = runs_of(e, 3, 2);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(few.trajectories[i].states, many.trajectories[i].states);
    EXPECT_EQ(few.trajectories[i].inputs, many.trajectories[i].inputs);
    EXPECT_NE(few.trajectories[i].inputs, other.trajectories[i].inputs);
  }
}

TEST(SimulateRuns, EachRunHasItsOwnParametersWithinTheRange) {
  const Experiment e = experiment(kLag, {"plant.parameters.a=[0.7, 1.3]"});
  EXPECT_DOUBLE_EQ(value_of(*e.plant, "a"), 1.0) << "the nominal value is the middle";
  const Dataset set = runs_of(e, 60);
  std::set<double> rates;
  for (std::size_t i = 0; i < set.trajectories.size(); ++i) {
    const Eigen::MatrixXd& x = set.trajectories[i].states;
    const double a = -std::log(x(0, x.cols() - 1) / x(0, 0)) / 10.0;  // x = x(0) exp(-a t)
    const double drawn = value_of(draw_parameters(*e.plant, initial_state_seed(1, SeedStream::kTest), i), "a");
    EXPECT_NEAR(a, drawn, 1e-8) << "RK4: a (a h)^4 / 120";
    EXPECT_GE(drawn, 0.7);
    EXPECT_LE(drawn, 1.3);
    rates.insert(drawn);
  }
  EXPECT_EQ(rates.size(), 60u);
  EXPECT_LT(*rates.begin(), 0.75);  // 60 uniform draws miss this range once in 150
  EXPECT_GT(*rates.rbegin(), 1.25);
}

TEST(SimulateRuns, TheDrawOfAParameterDependsOnlyOnItsName) {
  const auto drawn = [](const std::vector<std::string>& changes) {
    return value_of(draw_parameters(*experiment(kLag, changes).plant, 5, 2), "b");
  };
  const double alone = drawn({"plant.parameters.b=[1, 2]"});
  EXPECT_EQ(alone, drawn({"plant.parameters.a=[1, 2]", "plant.parameters.b=[1, 2]"}));
  EXPECT_EQ(alone, drawn({"plant.parameters.b=[1, 2]", "plant.parameters.a=[1, 2]"}));
  const PlantConfig both =
      draw_parameters(*experiment(kLag, {"plant.parameters.b=[1, 2]", "plant.parameters.a=[1, 2]"}).plant, 5, 2);
  EXPECT_NE(value_of(both, "a"), value_of(both, "b"));
}

TEST(SimulateRuns, ParametersOfBuiltInPlantsAreAlsoDrawn) {
  const std::string text =
      "name = \"vdp\"\n[plant]\nmodel = \"van_der_pol\"\nparameters = { mu = [0.7, 1.3] }\n"
      "[simulation]\nhorizon_s = 5\ninitial_low = [1, 1]\ninitial_high = [1, 1]\n"
      "[observer]\neigenvalues = [-3.0]\n";
  const Dataset set = runs_of(experiment(text), 3);
  EXPECT_EQ(set.trajectories[0].states.col(0), set.trajectories[1].states.col(0))
      << "both runs have the same initial state";
  EXPECT_GT((set.trajectories[0].states - set.trajectories[1].states).cwiseAbs().maxCoeff(), 1e-2);
}

TEST(SimulateRuns, ProcessNoiseOnAnIntegratorIsARandomWalk) {
  const std::string text =
      "name = \"walk\"\n[plant]\nstates = [\"a\", \"b\"]\nderivative = [\"0\", \"0\"]\n"
      "outputs = [\"a\"]\n[simulation]\nhorizon_s = 4\nprocess_noise = [0.5, 0]\n"
      "initial_low = [0, 0]\ninitial_high = [0, 0]\n[observer]\neigenvalues = [-3.0]\n";
  constexpr int kWalks = 2000;  // a variance is known to 3.2 % (one standard error)
  const Dataset set = runs_of(experiment(text), kWalks);
  for (const Eigen::Index k : {50, 200}) {
    double square = 0.0;
    for (const Trajectory& run : set.trajectories) {
      square += run.states(0, k) * run.states(0, k);
      ASSERT_EQ(run.states(1, k), 0.0) << "no noise on b";
    }
    const double variance = 0.25 * static_cast<double>(k) * kStep;  // sigma^2 t
    EXPECT_NEAR(square / kWalks, variance, 4.0 * 0.032 * variance);
  }
}

TEST(SimulateRuns, ProcessNoiseOnALagSettlesAtItsStationaryVariance) {
  const Experiment e = experiment(kLag, {"simulation.process_noise=[0.5]"});
  const Dataset set = runs_of(e, 2000);
  double square = 0.0;
  for (const Trajectory& run : set.trajectories) square += std::pow(run.states(0, run.samples() - 1), 2);
  const double phi = std::exp(-kRate * kStep);  // after 10 s x(0) is forgotten: exp(-20)
  const double variance = 0.25 * kStep / (1.0 - phi * phi);
  EXPECT_NEAR(variance, 0.25 / (2.0 * kRate), 0.05 * variance) << "sigma^2 / (2 a), apart from the finite step";
  EXPECT_NEAR(square / 2000, variance, 4.0 * 0.032 * variance);
}

TEST(SimulateRuns, ProcessNoiseActsOnItsShareOfTheRunsAndChangesNoOtherRun) {
  constexpr int kRuns = 200;
  const Dataset none = runs_of(experiment(kLag, {"simulation.process_noise=[0]"}), kRuns);
  const Dataset all = runs_of(experiment(kLag, {"simulation.process_noise=[0.5]"}), kRuns);
  for (const double share : {0.0, 0.25, 0.5, 1.0}) {
    const Experiment e =
        experiment(kLag, {"simulation.process_noise=[0.5]", "simulation.process_noise_share=" + std::to_string(share)});
    const Dataset some = runs_of(e, kRuns);
    int noisy = 0;
    for (std::size_t i = 0; i < kRuns; ++i) {
      const bool has_noise = e.simulation.has_process_noise(i);
      noisy += has_noise;
      ASSERT_EQ(some.trajectories[i].states, (has_noise ? all : none).trajectories[i].states) << share << " " << i;
      ASSERT_NE(all.trajectories[i].states, none.trajectories[i].states) << "control";
    }
    EXPECT_NEAR(noisy, share * kRuns, 4.0);
  }
}

// The noises of a mixture and closed loops repeat after a few runs. Each place of such a pattern has the share.
TEST(SimulateRuns, TheShareWithProcessNoiseIsTheSameInEveryPeriodicSelectionOfRuns) {
  SimulationConfig simulation;
  simulation.process_noise = {0.1};
  simulation.process_noise_share = 0.25;
  constexpr int kChosen = 1000;
  for (std::uint64_t period = 1; period <= 32; ++period)
    for (std::uint64_t place = 0; place < period; ++place) {
      int noisy = 0;
      for (std::uint64_t i = 0; i < kChosen; ++i) noisy += simulation.has_process_noise(place + i * period);
      EXPECT_NEAR(noisy, 250, 16) << period << " " << place;
    }
}

TEST(SimulateRuns, AGivenInputReplacesTheDrawnOne) {
  const Experiment e = experiment(kExcited);
  const auto plant = make_plant(*e.plant);
  const Excitation u = parse_excitation(*plant, {"sin(3*t)"});
  const Dataset given = runs_of(e, 2, 1, u);
  EXPECT_EQ(given.trajectories[0].states,
            simulate(*plant, e.simulation, initial_state_seed(1, SeedStream::kTest), 2, 1.0, u).trajectories[0].states);
  // With drawn parameters each run is simulated separately, and u(t) is still evaluated at the stages of RK4.
  const Experiment range = experiment(kExcited, {"plant.parameters.a=[2, 2]"});
  const Dataset alone = runs_of(range, 2, 1, u);
  EXPECT_LE((alone.trajectories[1].states - given.trajectories[1].states).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_EQ(alone.trajectories[1].inputs, given.trajectories[1].inputs);
}

TEST(SimulateRuns, TrainingAndValidationSetsHaveDifferentInputs) {
  const TrainingSets sets = simulate_training_sets(experiment(kExcited));
  for (const Dataset* set : {&sets.training, &sets.validation}) {
    ASSERT_EQ(set->inputs.size(), 1u);
    for (const Trajectory& run : set->trajectories) ASSERT_EQ(run.inputs.cols(), run.samples());
  }
  EXPECT_NE(sets.training.trajectories[0].inputs, sets.validation.trajectories[0].inputs);
  EXPECT_TRUE(simulate_training_sets(experiment(kLag)).training.inputs.empty());
}

}  // namespace
}  // namespace nlo::trainer
