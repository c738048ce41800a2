// SPDX-License-Identifier: MIT
// The loop of [feedback] on a linear plant, which has a closed form: x_{k+1} = (Ad - Bd K) x_k.
#include "trainer/plants/state_feedback.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "codegen/replay/reference_observer.h"
#include "tests/support/thrown_message.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/training_sets.h"
#include "trainer/learn/training/train.h"
#include "trainer/plants/initial_states.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/simulate_runs.h"

namespace nlo::trainer {
namespace {

/// An inverted pendulum about its upright position: dx/dt = [0 1; 4 0] x + [0; 1] u, poles at +-2; y = angle.
const std::string kUpright = R"(name = "upright"
threads = 1
[plant]
states = ["angle", "rate"]
derivative = ["rate", "4*angle + u"]
outputs = ["angle"]
output_names = ["y"]
inputs = ["u"]
[simulation]
horizon_s = 3.0
sample_period_s = 0.02
trajectories = 8
initial_low = [-0.2, -0.2]
initial_high = [0.2, 0.2]
[feedback]
law = ["-(12*angle + 5*rate) + r_u"]
actuator_low = [-50]
actuator_high = [50]
[observer]
eigenvalues = [-4.0, -6.0, -9.0]
learn_eigenvalues = false
[inverse_map]
hidden = [4]
linear_path = true
[training]
steps = 5
samples_per_step = 256
)";

constexpr double kPole = 2.0, kStep = 0.02;

Experiment experiment(const std::vector<std::string>& changes = {}) {
  return parse_experiment(kUpright, "e.toml", changes);
}

Dataset runs_of(const Experiment& e, const codegen::Model* observer = nullptr, Eigen::Index count = 8) {
  const auto plant = make_plant(*e.plant);
  const LoopEstimators estimators = observer == nullptr ? nullptr : observer_in_loop(*observer, e, *plant);
  return simulate_runs(e, *plant, initial_state_seed(1, SeedStream::kTest), count, 1.0, {}, estimators);
}

/// Ad and Bd of the plant, with its input held over the period, and the gain of the law.
struct Loop {
  Eigen::Matrix2d a;
  Eigen::Vector2d b;
  Eigen::RowVector2d gain{12.0, 5.0};

  Loop() {
    const double c = std::cosh(kPole * kStep), s = std::sinh(kPole * kStep);
    a << c, s / kPole, kPole * s, c;
    b << (c - 1.0) / (kPole * kPole), s / kPole;
  }
};

double largest(const Dataset& set) {
  double most = 0.0;
  for (const Trajectory& run : set.trajectories) most = std::max(most, run.inputs.cwiseAbs().maxCoeff());
  return most;
}

TEST(StateFeedback, FromTheTrueStateGivesTheClosedLoopMatrix) {
  const Loop loop;
  const Dataset set = runs_of(experiment());
  double worst = 0.0, open = 0.0;
  for (const Trajectory& run : set.trajectories) {
    Eigen::Vector2d x = run.states.col(0), free = x;
    for (Eigen::Index k = 1; k < run.samples(); ++k) {
      x = (loop.a - loop.b * loop.gain) * x;
      free = loop.a * free;
      worst = std::max(worst, (run.states.col(k) - x).norm());
      open = std::max(open, (run.states.col(k) - free).norm());
    }
  }
  EXPECT_LT(worst, 1e-8);  // RK4: (2 h)^5 / 120 = 9e-10 of |x| < 1 per step, forgotten by the loop within 20 steps
  EXPECT_GT(open, 1.0) << "control: without the loop the pendulum falls";
}

/// The plant with a third state that decays independently, and an observer that does not estimate it.
Experiment with_hidden_state(const std::vector<std::string>& changes = {}) {
  std::string text = kUpright;
  const auto replace = [&](const std::string& old, const std::string& by) {
    text.replace(text.find(old), old.size(), by);
  };
  replace("[\"angle\", \"rate\"]", "[\"angle\", \"rate\", \"heat\"]\nestimated = [\"rate\", \"angle\"]");
  replace("\"4*angle + u\"]", "\"4*angle + u\", \"-heat\"]");
  replace("[-0.2, -0.2]", "[-0.2, -0.2, 0]");
  replace("[0.2, 0.2]", "[0.2, 0.2, 0]");
  return parse_experiment(text, "e.toml", changes);
}

TEST(StateFeedback, OverTheEstimatedStatesEqualsThatOverAllStates) {
  const Dataset all = runs_of(experiment({"feedback.error=[0.01, 0.02]"}), nullptr, 1),
                some = runs_of(with_hidden_state({"feedback.error=[0.01, 0.02, 5]"}), nullptr, 1);
  // From the second run on, the third initial state is drawn between those of the others; the first run has the same
  // initial state.
  EXPECT_TRUE(some.trajectories[0].states.topRows(2).isApprox(all.trajectories[0].states, 1e-12));
  EXPECT_GT(largest(all), 0.1);
}

TEST(StateFeedback, ReadsTheEstimatesOfAnObserverOfSomeStates) {
  const Experiment e = with_hidden_state();
  const TrainingSets sets = simulate_training_sets(e);
  const codegen::Model model = train(e, sets.training, sets.validation, {}).model;
  ASSERT_EQ(model.states.size(), 2U);
  ASSERT_EQ(model.states[0].name, "rate");
  const Dataset with = runs_of(e, &model);
  codegen::ReferenceObserver<float> observer(model);
  for (const Trajectory& run : with.trajectories) {
    ASSERT_EQ(run.states.rows(), 3);
    const Eigen::MatrixXd x_hat = observer.run(run.outputs, run.inputs, run.time_s, true).x_hat;
    for (Eigen::Index k = 0; k + 1 < run.samples(); ++k)
      ASSERT_NEAR(run.inputs(0, k + 1), -(12.0 * x_hat(1, k) + 5.0 * x_hat(0, k)), 1e-4);
  }
}

TEST(StateFeedback, AConstantErrorOfTheEstimateShiftsTheSteadyStateByItsGain) {
  // In steady state 4 angle = K (x + e), so angle = -K e / (K1 - 4).
  const Dataset set = runs_of(experiment({"feedback.error=[0.01, 0.02]", "simulation.horizon_s=12"}));
  for (const Trajectory& run : set.trajectories) {
    const Eigen::Vector2d rest = run.states.col(run.samples() - 1);
    EXPECT_NEAR(rest(1), 0.0, 1e-8);
    EXPECT_NEAR(run.inputs(0, run.samples() - 1), -4.0 * rest(0), 1e-6) << "the law holds it in the steady state";
    EXPECT_GT(std::abs(rest(0)), 1e-5) << "control: without an error the angle would be 0";
  }
}

TEST(StateFeedback, IsClippedToTheLimitsOfItsActuator) {
  const Dataset free = runs_of(experiment()),
                clipped = runs_of(experiment({"feedback.actuator_low=[-0.5]", "feedback.actuator_high=[0.25]"}));
  EXPECT_GT(largest(free), 1.0);
  double least = 0.0, most = 0.0;
  for (const Trajectory& run : clipped.trajectories) {
    least = std::min(least, run.inputs.minCoeff());
    most = std::max(most, run.inputs.maxCoeff());
  }
  EXPECT_EQ(least, -0.5);
  EXPECT_EQ(most, 0.25);
}

TEST(StateFeedback, UsesDrawnInputsAsReferencesInItsShareOfTheRuns) {
  const std::vector<std::string> drawn = {"excitation.low=[-1]", "excitation.high=[1]"};
  std::vector<std::string> half = drawn;
  half.emplace_back("feedback.share=0.5");
  const Dataset all = runs_of(experiment(drawn)), some = runs_of(experiment(half));
  const Experiment open = parse_experiment(
      kUpright.substr(0, kUpright.find("[feedback]")) + kUpright.substr(kUpright.find("[observer]")), "e.toml", drawn);
  const Dataset none = runs_of(open);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(some.trajectories[i].states, (i % 2 == 1 ? all : none).trajectories[i].states) << i;
    const Trajectory& run = all.trajectories[i];
    for (Eigen::Index k = 0; k + 1 < run.samples(); ++k) {
      const double reference = none.trajectories[i].inputs(0, k + 1);
      const double u = -(12.0 * run.states(0, k) + 5.0 * run.states(1, k)) + reference;
      ASSERT_NEAR(run.inputs(0, k + 1), u, 1e-12);  // the same terms, summed in another order
    }
  }
}

TEST(StateFeedback, UsesTheEstimatesOfAnObserver) {
  const Experiment e = experiment();
  const TrainingSets sets = simulate_training_sets(e);
  EXPECT_TRUE(sets.training.reads_inputs);
  const codegen::Model model = train(e, sets.training, sets.validation, {}).model;
  const Dataset with = runs_of(e, &model), without = runs_of(e);
  codegen::ReferenceObserver<float> observer(model);
  double other = 0.0;
  for (std::size_t i = 0; i < with.trajectories.size(); ++i) {
    const Trajectory& run = with.trajectories[i];
    const Eigen::MatrixXd x_hat = observer.run(run.outputs, run.inputs, run.time_s, true).x_hat;
    for (Eigen::Index k = 0; k + 1 < run.samples(); ++k) {
      const double u = -(12.0 * x_hat(0, k) + 5.0 * x_hat(1, k));
      // Float: a batch of samples is summed in another order than a single sample.
      ASSERT_NEAR(run.inputs(0, k + 1), u, 1e-4);
    }
    other = std::max(other, (run.inputs - without.trajectories[i].inputs).cwiseAbs().maxCoeff());
  }
  EXPECT_GT(other, 1e-3) << "control: the loop is not closed by the true state";
}

TEST(FeedbackRounds, AddRunsInTheLoopOfTheLastObserverAlsoForValidation) {
  const Experiment e = experiment({"feedback.rounds=1"});
  const TrainingSets none = simulate_training_sets(experiment()), first = simulate_training_sets(e);
  const codegen::Model model = train(e, first.training, first.validation, {}).model;
  const TrainingSets second = next_round(e, {1, &model}, first), again = next_round(e, {1, &model}, first);
  const TrainingSets of_true_state = next_round(e, {1, nullptr}, first);
  ASSERT_EQ(second.training.trajectories.size(), 2 * first.training.trajectories.size());
  EXPECT_EQ(second.validation.trajectories.size(), first.validation.trajectories.size());
  for (std::size_t i = 0; i < first.training.trajectories.size(); ++i) {
    const auto states = [i](const TrainingSets& sets, std::size_t after = 0) -> const Eigen::MatrixXd& {
      return sets.training.trajectories[after + i].states;
    };
    const std::size_t added = first.training.trajectories.size();
    EXPECT_EQ(states(first), states(none)) << "round 0 uses the loop of the true state, for any number of rounds";
    EXPECT_EQ(states(second), states(first)) << "runs of round 0 are kept";
    EXPECT_EQ(states(second, added), states(again, added));
    EXPECT_NE(states(second, added), states(of_true_state, added)) << "the observer is in the loop";
    EXPECT_TRUE(states(second, added).col(0) == states(of_true_state, added).col(0));
    EXPECT_FALSE(states(second, added).col(0) == states(first).col(0)) << "with new initial states";
  }
}

TEST(StateFeedback, RefusesAnObserverWithoutTheInput) {
  const Experiment e = experiment();
  const TrainingSets sets = simulate_training_sets(e);
  Dataset blind = sets.training, blind_validation = sets.validation;
  blind.reads_inputs = blind_validation.reads_inputs = false;
  const codegen::Model model = train(e, blind, blind_validation, {}).model;
  EXPECT_THAT(thrown_message([&] { runs_of(e, &model); }), testing::HasSubstr("cannot close the loop"));
}

}  // namespace
}  // namespace nlo::trainer
