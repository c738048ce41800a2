// SPDX-License-Identifier: MIT
// A plant given by expressions, with an angle that wraps and with inputs that its observer does not read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <sstream>

#include "tests/commands/program.h"
#include "trainer/base/number_text.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double kTurn = 2.0 * std::numbers::pi;

/// A pendulum that makes full turns from its fastest initial states. Its angle is measured, its rate is estimated.
const std::string kPendulum = R"(name = "pendulum"

[plant]
states = ["theta", "omega"]
state_units = ["rad", "rad/s"]
derivative = ["omega", "-9.81*sin(theta) - 0.05*omega"]
output_names = ["angle"]
outputs = ["theta"]
output_units = ["rad"]
state_wraps = ["2pi", 0]
output_wraps = ["2pi"]
estimated = ["omega"]

[simulation]
horizon_s = 4.0
sample_period_s = 0.01
trajectories = 48
initial_low = [-3.1, -12.0]
initial_high = [3.1, 12.0]

[observer]
pairs = [[-15.0, 15.0], [-30.0, 20.0]]
learn_eigenvalues = false
output_injection = "unit_gain"
start = "steady"
features = "latent_minus_output"
clocks_s = [0.05]

[inverse_map]
hidden = [12]
linear_path = true

[training]
steps = 600
trajectories_per_step = 16
samples_per_step = 1024
learning_rate = 1e-2
noise = "gaussian:0.02"
)";

struct Columns {
  std::vector<double> angle, measured, omega;
};

/// Columns of `nlo simulate`: trajectory,time,angle,angle_measured,theta,omega.
Columns columns_of(const std::string& csv) {
  Columns columns;
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "trajectory,time,angle,angle_measured,theta,omega");
  while (std::getline(lines, line)) {
    std::istringstream row(line);
    std::vector<double> values;
    for (std::string cell; std::getline(row, cell, ',');) values.push_back(std::stod(cell));
    if (values.size() != 6) ADD_FAILURE() << line;
    columns.angle.push_back(values[2]);
    columns.measured.push_back(values[3]);
    EXPECT_EQ(values[4], values[2]);
    columns.omega.push_back(values[5]);
  }
  return columns;
}

/// The flight program: reads one measurement per line and prints one estimate per line.
const std::string kFlight = R"(#include <stdio.h>
#include <pendulum.h>
int main(void) {
  static pendulum_observer observer;
  pendulum_init(&observer);
  float y[1], x_hat[1];
  int in_domain = 1;
  while (scanf("%f", y) == 1) {
    if (pendulum_step(&observer, y) != pendulum_OK) return 1;
    pendulum_estimate(&observer, x_hat);
    in_domain &= pendulum_in_domain(&observer);
    printf("%.9g\n", (double)x_hat[pendulum_state_omega]);
  }
  return in_domain ? 0 : 2;
}
)";

TEST(PlantWithAnAngle, IsTrainedExportedAndFlownThroughFullTurns) {
  const Scratch scratch;
  scratch.write("pendulum.toml", kPendulum);
  const auto train = scratch.ok({"train", "pendulum.toml", "-o", "run", "-q"});
  scratch.ok({"export", "run/model.json", "--target", "c99", "-q", "-o", "pendulum.h"});
  // Turns over the top within a second, for 4 s, from a state of the training box that no training run has.
  const auto simulated = scratch.ok({"simulate", "pendulum.toml", "--set", "simulation.initial_low=[2.5, 9.5]", "--set",
                                     "simulation.initial_high=[2.5, 9.5]", "--noise", "gaussian:0.02", "-o", "-"});
  const Columns run = columns_of(simulated.out);
  ASSERT_EQ(run.angle.size(), 401u);
  int turns = 0;
  for (std::size_t k = 0; k < run.angle.size(); ++k) {
    ASSERT_LE(std::abs(run.angle[k]), 0.5 * kTurn);
    ASSERT_LE(std::abs(run.measured[k]), 0.5 * kTurn) << "as a sensor with a wrap measures it";
    if (k > 0 && run.angle[k] < run.angle[k - 1] - 0.5 * kTurn) ++turns;
  }
  EXPECT_GE(turns, 5) << "control: the angle wraps";

  std::string measurements;
  for (const double y : run.measured) measurements += shortest_text(y) + "\n";
  if (std::string(NLO_CC).empty()) GTEST_SKIP() << "no C compiler here";
  scratch.write("y.txt", measurements);
  scratch.write("flight.c", kFlight);
  const std::string command = "cd " + scratch.path() +
                              " && \"" NLO_CC
                              "\" -std=c99 -O1 -I. flight.c pendulum.c -o flight && "
                              "./flight <y.txt >omega.txt";
  ASSERT_EQ(std::system(command.c_str()), 0);
  std::istringstream estimates(scratch.read("omega.txt"));
  double ours = 0.0, differences = 0.0;
  constexpr std::size_t kSettled = 50;  // 0.5 s: seven time constants of the slowest pair
  for (std::size_t k = 0; k < run.omega.size(); ++k) {
    double omega = 0.0;
    ASSERT_TRUE(estimates >> omega) << k;
    if (k < kSettled) continue;
    const double difference = std::remainder(run.measured[k] - run.measured[k - 1], kTurn) / 0.01;
    ours += std::pow(omega - run.omega[k], 2);
    differences += std::pow(difference - run.omega[k], 2);
  }
  const auto rms = [&](double sum) { return std::sqrt(sum / static_cast<double>(run.omega.size() - kSettled)); };
  // A difference of two angles has sqrt(2) * 0.02 rad / 0.01 s = 2.8 rad/s of noise. If the observer took the wrap for
  // motion, its error would be several hundred rad/s.
  EXPECT_NEAR(rms(differences), 2.83, 0.5);
  EXPECT_LT(rms(ours), 0.2 * rms(differences)) << rms(ours) << " rad/s";

  const auto table = scratch.ok(
      {"evaluate", "run/model.json", "--noise", "gaussian:0.02", "--trajectories", "20", "--against", "ekf,constant"});
  EXPECT_THAT(table.out, HasSubstr("RMSE omega [rad/s]"));
  EXPECT_THAT(table.out, Not(HasSubstr("theta")));
}

/// Returns the last cell of the last row that begins with `row`: wide results have two tables, with errors of states in
/// the second.
std::string last_cell(const std::string& text, const std::string& row) {
  std::istringstream lines(text);
  std::string found;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream cells(line);
    std::string cell;
    if (!(cells >> cell) || cell != row) continue;
    while (cells >> cell) found = cell;
  }
  EXPECT_NE(found, "") << "no row " << row << " in " << text;
  return found;
}

TEST(PlantWithAnAngle, MayHaveSineAndCosineAsOutputs) {
  const Scratch scratch;
  const std::vector<std::string> evaluate = {"evaluate", "run/model.json", "--noise", "gaussian:0.02", "--trajectories",
                                             "5",        "--against",      "ekf"};
  scratch.write("pendulum.toml", with(kPendulum, "steps = 600", "steps = 5"));
  (void)scratch.run({"train", "pendulum.toml", "-o", "run", "-q"});  // 5 steps may not improve the model, which is kept
  const auto unwrapped = scratch.ok(evaluate);

  std::string text = with(kPendulum, "estimated = [\"omega\"]",
                          "state_encodings = [\"sincos\", \"unwrap\"]\noutput_encodings = [\"sincos\"]");
  text = with(text, "latent_minus_output", "latent_and_output");
  text = with(text, "steps = 600", "steps = 5");
  scratch.write("pendulum.toml", text);
  const auto train = scratch.run({"train", "pendulum.toml", "-o", "run", "-q"});
  for (const char* name : {"RMSE theta_sin", "RMSE theta_cos", "RMSE omega"}) EXPECT_THAT(train.out, HasSubstr(name));
  // The same sensor noise in both encodings: the filter that knows the plant is as accurate with both.
  const auto encoded = scratch.ok(evaluate);
  EXPECT_EQ(last_cell(encoded.out, "ekf"), last_cell(unwrapped.out, "ekf"));
  EXPECT_THAT(scratch.refusal(2, {"evaluate", "run/model.json", "--noise", "gaussian:0.02,none"}),
              HasSubstr("is for 2 outputs, but there is 1"));
}

TEST(PlantWithInputs, NotesThatItsObserverDoesNotReadThem) {
  const Scratch scratch;
  const std::string equations =
      "states = [\"x1\", \"x2\"]\nderivative = [\"x2\", \"-x1 + u\"]\noutput_names = [\"y\"]\noutputs = [\"x1\"]\n"
      "inputs = [\"u\"]\n";
  scratch.write("tiny.toml", with(kTinyExperiment, "model = \"van_der_pol\"\n", equations));
  const auto train = scratch.ok({"train", "tiny.toml", "-o", "run"});
  EXPECT_THAT(train.err, HasSubstr("note: this kkl observer was trained without inputs, so it does not know u"));
  EXPECT_THAT(scratch.read("run/report.html"), HasSubstr("ignored_inputs"));
  const auto exported = scratch.run({"export", "run/model.json", "-o", "tiny.h"});
  EXPECT_THAT(exported.err, HasSubstr("does not know u"));
  EXPECT_THAT(scratch.read("tiny.h"), HasSubstr("ignored_inputs                u\n"));
  EXPECT_EQ(scratch.run({"export", "run/model.json", "-q", "-o", "tiny.h"}).err, "");
  // Control: the experiment does not use the input of its built-in plant, so the observer misses no input.
  scratch.write("built_in.toml", kTinyExperiment);
  EXPECT_THAT(scratch.run({"train", "built_in.toml", "-o", "none"}).err, Not(HasSubstr("without inputs")));
  EXPECT_EQ(scratch.run({"export", "none/model.json", "-o", "none.h"}).err, "");
}

TEST(PlantWithInputs, IsEvaluatedWithTheInputsThatItsExperimentDraws) {
  const Scratch scratch;
  scratch.write("excited.toml", kTinyExperiment + "[excitation]\nkinds = [\"steps\"]\nlow = [-2]\nhigh = [2]\n");
  const auto train = scratch.ok({"train", "excited.toml", "-o", "run"});
  const auto evaluate = [&](const std::string& run, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"evaluate", run + "/model.json", "--trajectories", "5", "--against", "ekf"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto result = scratch.ok(arguments);
    return result.out;
  };
  const std::string drawn = evaluate("run", {});
  EXPECT_THAT(drawn, HasSubstr("u = drawn within -2 .. 2 (steps)"));
  EXPECT_THAT(evaluate("run", {"--set", "excitation.kinds=[\"prbs\"]"}), HasSubstr("drawn within -2 .. 2 (prbs)"));
  EXPECT_THAT(evaluate("run", {"--input", "sin(t)"}), HasSubstr("u = sin(t)"));
  // The filter knows the inputs of each run, so it is as accurate as without inputs; the constant is not.
  scratch.write("quiet.toml", with(kTinyExperiment, "[training]", "[training]\nmirror = true"));
  scratch.ok({"train", "quiet.toml", "-o", "quiet"});
  const std::string quiet = evaluate("quiet", {}),
                    set = evaluate("quiet", {"--set", "excitation.low=[-2]", "--set", "excitation.high=[2]"});
  EXPECT_THAT(set, HasSubstr("u = drawn within -2 .. 2 (constant, steps"));
  const double without = std::stod(last_cell(quiet, "ekf"));
  EXPECT_LT(std::stod(last_cell(drawn, "ekf")), 2.0 * without) << drawn;
  EXPECT_LT(std::stod(last_cell(set, "ekf,")), 2.0 * without) << set;  // "ekf, nominal parameters"
}

TEST(PlantWithInputs, SimulatesDrawnParametersOnRequest) {
  const Scratch scratch;
  scratch.write("tiny.toml", with(kTinyExperiment, "model = \"van_der_pol\"",
                                  "model = \"van_der_pol\"\nparameters = { mu = [0.2, 3] }"));
  const auto simulated = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"simulate", "tiny.toml", "-o", "-"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return scratch.run(arguments).out;
  };
  const std::string nominal = simulated({});
  EXPECT_EQ(nominal, simulated({"--set", "plant.parameters.mu=1.6"})) << "the middle of the range";
  EXPECT_NE(nominal, simulated({"--draw-parameters"}));
  EXPECT_EQ(simulated({"--draw-parameters"}), simulated({"--draw-parameters"}));
  EXPECT_THAT(simulated({"--set", "excitation.low=[-1]", "--set", "excitation.high=[1]"}),
              HasSubstr("trajectory,time,y,y_measured,x1,x2,u\n"));
}

}  // namespace
}  // namespace nlo::trainer
