// SPDX-License-Identifier: MIT
// Training of an observer with a prior: gradients through time, equations and range agree with finite differences, and
// roll-outs equal flight.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "codegen/model/expression_derivative.h"
#include "codegen/model_file/model_file.h"
#include "codegen/replay/reference_observer.h"
#include "tests/support/thrown_message.h"
#include "tests/training/training_testing.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/training_sets.h"
#include "trainer/learn/training/train.h"
#include "trainer/plants/plant_expression.h"
#include "trainer/structures/equation_tape.h"
#include "trainer/structures/prior_lanes.h"

namespace nlo::trainer {
namespace {

using testing::harmonics;

/// A driven Van der Pol oscillator with y = x1 + x2 / 4, three units, and a random linear functional of z as the loss.
struct PriorProblem {
  int length;
  std::vector<double> theta, readings, latent, cotangent, periods;
  std::vector<std::uint8_t> held;
  PriorSetting setting;
  std::unique_ptr<PriorLanes<double>> lanes;
  GatedRun<double> run;

  PriorProblem(int samples, bool jittered, double range, bool commands = false,
               const codegen::EquationTexts& equations = {{"x2", "mu * (1 - x1^2) * x2 - x1 + u"},
                                                          {"x1 + x2 / 4"},
                                                          {{"mu", 1.1}}})
      : length(samples) {
    setting.equations = codegen::Equations(equations, {{"x1", ""}, {"x2", ""}}, {{"u", ""}});
    setting.units = 3;
    setting.readings = 2;
    setting.inputs = 1;
    setting.commands = commands;
    setting.period_s = 0.1;
    setting.start = {0.1, -0.2, 0.5, 0.1, 0.8};
    setting.low = {-range, -1.1 * range, 1e-9, -range, 1e-9};
    setting.high = {1.2 * range, range, range, range, range};
    setting.fine = {0.1};
    setting.coarse = {1.5};
    setting.state_noise = {0.02, 0.05};
    setting.output_noise = {0.3};
    setting.scale = {0.4, 0.3, 0.2, 0.25, 0.7, 0.9, 0.8};
    setting.read = {{0.0, 0.1, 0.2, -0.1, 0.0, 0.1}, {0.5, 0.25, 0.7, 1.4, 1.1, 0.9}};
    lanes = std::make_unique<PriorLanes<double>>(setting);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    const auto draw = [&](std::vector<double>& values, std::size_t count) {
      values.resize(count);
      for (double& value : values) value = uniform(random);
    };
    const auto row = static_cast<std::size_t>(length) * kGroup;
    draw(theta, static_cast<std::size_t>(lanes->parameters()));
    draw(readings, 2 * row);
    draw(cotangent, 8 * row);
    latent.resize(8 * row);
    if (jittered) {
      draw(periods, row);
      for (double& m : periods) m = 1.6 + 1.4 * m;  // up to three pieces
    }
    run = {length, readings.data(), latent.data(), cotangent.data(), jittered ? periods.data() : nullptr};
  }

  double loss() {
    lanes->prepare(theta.data());
    lanes->forward(run);
    double sum = 0.0;
    for (std::size_t i = 0; i < latent.size(); ++i) sum += latent[i] * cotangent[i];
    return sum;
  }

  double worst_of_gradient() {
    loss();
    std::vector<double> gradient;
    lanes->backward(run, gradient);
    double worst = 0.0, largest = 0.0;
    for (std::size_t p = 0; p < theta.size(); ++p) {
      constexpr double kStep = 1e-5;
      const double centre = theta[p];
      const auto at = [&](double offset) {
        theta[p] = centre + offset;
        return loss();
      };
      const double expected = (8.0 * (at(kStep) - at(-kStep)) - (at(2.0 * kStep) - at(-2.0 * kStep))) / (12.0 * kStep);
      theta[p] = centre;
      worst = std::fmax(worst, std::fabs(gradient[p] - expected));
      largest = std::fmax(largest, std::fabs(expected));
    }
    EXPECT_GT(largest, 0.1) << "control: there is a gradient";
    return worst / largest;
  }

  bool touches_range() const {
    for (int k = 0; k < length * kGroup; ++k)
      for (int i = 0; i < 5; ++i) {
        const double x = latent[static_cast<std::size_t>((3 + i) * length * kGroup + k)];
        if (x == setting.low[static_cast<std::size_t>(i)] || x == setting.high[static_cast<std::size_t>(i)])
          return true;
      }
    return false;
  }
};

TEST(PriorLanes, GradientsThroughTimeAgreeWithFiniteDifferences) {
  // Fourth-order differences: the remaining errors are kStep^4 and the rounding 1e-16 |loss| / kStep, over about 100
  // kinks of |nu|.
  for (const int samples : {1, 2, 33, 75})
    for (const bool jittered : {false, true}) {
      PriorProblem problem(samples, jittered, 30.0, jittered);
      EXPECT_LT(problem.worst_of_gradient(), 3e-8) << samples << " " << jittered;
      EXPECT_FALSE(problem.touches_range());
    }
}

TEST(PriorLanes, GradientsIncludeAnOutputThatDependsOnAnInput) {
  PriorProblem problem(33, true, 30.0, true,
                       {{"x2", "mu * (1 - x1^2) * x2 - x1 + u"}, {"x1 + x2 / 4 + 0.5 * u * x1"}, {{"mu", 1.1}}});
  EXPECT_LT(problem.worst_of_gradient(), 3e-8) << "as above";
}

TEST(PriorLanes, GradientsIncludeFunctionsAndQuotients) {
  const codegen::EquationTexts equations = {
      {"x2 / (2 + cos(x1)^2) + atan(u)", "-sin(x1) - tanh(x2 / 2) - x2 * abs(x2) / 4 + exp(-x1^2) * u + sign(u) / 9"},
      {"x1 / sqrt(4 + x2^2) + ln(2 + x1^2) / 3"}};
  PriorProblem problem(33, true, 30.0, true, equations);
  EXPECT_LT(problem.worst_of_gradient(), 3e-8) << "as above, if no state passes 0 within a difference";
}

TEST(PriorLanes, GradientsIncludeMinimaAndMaxima) {
  const codegen::EquationTexts equations = {
      {"x2 + max(x1, -0.3) / 4 - min(x2, 0.5, x1) / 5", "u - x1 - max(x2, x1) / 3 - sqrt(max(x1, 0.1))"},
      {"x1 + max(x2, 0) / 4"}};
  PriorProblem problem(33, true, 30.0, true, equations);
  EXPECT_LT(problem.worst_of_gradient(), 3e-8) << "as above, if no state passes a kink within a difference";
}

TEST(PriorLanes, AnOutputThatIsNotMeasuredHasNoGradient) {
  PriorProblem problem(33, true, 30.0);
  const double measured = problem.loss();
  for (std::size_t i = 0; i < 33 * kGroup; ++i) problem.held.push_back(i % 5 < 2);
  problem.run.held = problem.held.data();
  EXPECT_NE(problem.loss(), measured) << "control";
  EXPECT_LT(problem.worst_of_gradient(), 3e-8);
}

TEST(PriorLanes, AClampedStateHasNoGradient) {
  PriorProblem problem(40, true, 0.6);
  EXPECT_LT(problem.worst_of_gradient(), 3e-8);
  EXPECT_TRUE(problem.touches_range()) << "control";
}

// Finite differences of the tape itself would not detect a wrongly combined number, because value and slope would
// agree.
TEST(EquationTape, HasTheValuesAndSlopesOfItsExpressions) {
  const std::vector<std::string> names = {"a", "b", "c"};
  std::vector<codegen::Expression> all;
  for (const char* text : {"a",
                           "c",
                           "3",
                           "2 * c",
                           "a + c - 2",
                           "c - a - 1",
                           "a - b",
                           "a * c * b",
                           "a / c",
                           "c / a",
                           "a / b",
                           "(a + b)^2 / (1 + a^2)",
                           "2 / (3 + b) - a / 4",
                           "sin(a) * cos(a) - tan(b / 3)",
                           "tanh(b) + exp(-a) * ln(2 + a^2)",
                           "sqrt(a^2 + 1) - atan(b) * abs(b) + sign(a) * b",
                           "sin(c) * (a + b) - cos(a + b)",
                           "max(a, b) - min(a, c)",
                           "max(0.8, b) * min(b, a + c)",
                           "max(c, 2) * a",
                           "sqrt(max(b, 0)) - min(c, 2) * b",
                           "max(a, a) + min(b, b)"})
    all.emplace_back(text, names, codegen::Expression::Language::kFunctions);
  const EquationTape<double> tape(codegen::SharedExpressions(all, 3), 2, {0.7});
  using L = Lanes<double>;
  std::vector<L> values(static_cast<std::size_t>(tape.size())), to(values);
  for (int l = 0; l < kGroup; ++l) {
    values[0][l] = 0.4 + 0.1 * l;
    values[1][l] = 0.3 * l - 1.3;
  }
  tape.evaluate(values.data());
  constexpr double kRounding = 1e-14;  // a few operations in another order, on values near 1
  for (std::size_t i = 0; i < all.size(); ++i) {
    tape.pull_back(
        values.data(), [&](int row) { return in_lanes<L>(row == static_cast<int>(i) ? 1.0 : 0.0); }, to.data());
    for (int l = 0; l < kGroup; ++l) {
      const double at[] = {values[0][l], values[1][l], 0.7};
      const auto number = [&](const codegen::Expression& of) {
        return of.evaluate<double>([&](int j) { return at[j]; });
      };
      EXPECT_NEAR(tape.row(values.data(), static_cast<int>(i))[l], number(all[i]), kRounding) << i;
      for (int j = 0; j < 2; ++j) {
        const double slope = number(codegen::expression_of(codegen::derivative(all[i], j)));
        // The derivative of sqrt by expressions has 1e-6 added to its divisor.
        EXPECT_NEAR(to[static_cast<std::size_t>(j)][l], slope, i == 15 ? 1e-6 : kRounding) << i << " " << j;
      }
    }
  }
}

Experiment prior_experiment(const std::string& observer, int units = 5) {
  Experiment experiment = parse_experiment(
      "name = \"p\"\n[plant]\nstates = [\"position\", \"velocity\"]\nderivative = [\"velocity\", \"-c * position\"]\n"
      "outputs = [\"position\"]\nparameters = { c = [3.0, 4.0] }\n[simulation]\ninitial_low = [-1.0, -1.0]\n"
      "initial_high = [1.0, 1.0]\n[observer]\nstructure = \"prior\"\nunits = " +
          std::to_string(units) + "\n" + observer +
          "[inverse_map]\nhidden = [8]\nlinear_path = true\n[training]\nsteps = 60\nlearning_rate = 0.01\n"
          "trajectories_per_step = 8\nsamples_per_step = 600\n",
      "prior.toml");
  experiment.threads = 1;
  return experiment;
}

TEST(Prior, TrainingEqualsFlight) {
  for (const bool jittered : {false, true}) {
    Dataset data = harmonics({60, 90, 75}, jittered);
    if (jittered) data.trajectories[1].time_s.tail(40).array() += 0.3;  // a gap of seven samples
    for (const char* features : {"", "features = \"latent_and_output\"\n"}) {
      const TrainingResult result = train(prior_experiment(features), data, data, {});
      ASSERT_EQ(result.model.nz(), 10) << "five units, two states and the triangle of their covariance";
      // Compared with double: float in the roll-out, and tanh of the runtime.
      EXPECT_NEAR(result.validation_rmse, testing::reference_rmse(result.model, data), 1e-3 * result.validation_rmse);
    }
  }
}

/// A prior with logs whose truth is v, driven by a and measured; the logs have one input more than the plant.
constexpr const char* kLogged = R"toml(name = "p"
[log]
sample_period_s = 0.05
train_files = ["a.csv"]
validation_files = ["b.csv"]
columns = [{ name = "time", role = "time", unit = "s" }, { name = "y", role = "output" }, { name = "w", role = "input" },
  { name = "a", role = "input" }, { name = "v", role = "state" }]
[plant]
states = ["v"]
inputs = ["a"]
derivative = ["a - 0.1 * v"]
output_names = ["y"]
outputs = ["v"]
[simulation]
initial_low = [-1.0]
initial_high = [1.0]
share = 0.0
[observer]
structure = "prior"
units = 4
[inverse_map]
hidden = [8]
linear_path = true
[training]
steps = 80
segment_s = 2.0
learning_rate = 0.01
trajectories_per_step = 8
samples_per_step = 600
)toml";

/// Logs of v = sin(t + phase) for a = v' + v / 10. The sensor of a has a constant bias in each log.
Dataset driven_logs(double most_bias) {
  Dataset logs;
  logs.outputs = {{"y", "", 0.0}};
  logs.states = {{"v", "", 0.0}};
  logs.sample_period_s = 0.05;
  logs.inputs = {{"w", "", 0.0}, {"a", "", 0.0}};
  logs.reads_inputs = true;
  std::mt19937 engine(3);
  std::normal_distribution<double> noise(0.0, 0.3);
  for (int log = 0; log < 4; ++log) {
    const Eigen::VectorXd t = Eigen::VectorXd::LinSpaced(400, 0.0, 19.95);
    Trajectory run{"a.csv", t, Eigen::MatrixXd(1, 400), Eigen::MatrixXd(1, 400), Eigen::VectorXd::Ones(400)};
    run.inputs = Eigen::MatrixXd::Zero(2, 400);
    const Eigen::ArrayXd angle = t.array() + 0.7 * log;
    run.states.row(0) = angle.sin().matrix();
    run.inputs.row(1) = (angle.cos() + 0.1 * angle.sin() + most_bias * std::cos(3.0 * log)).matrix();
    for (Eigen::Index k = 0; k < 400; ++k) run.outputs(0, k) = run.states(0, k) + noise(engine);
    logs.trajectories.push_back(std::move(run));
  }
  return logs;
}

TEST(Prior, StepsTheEquationsInTrainingOnLogs) {
  const Dataset logs = driven_logs(0.0);
  Experiment experiment = parse_experiment(kLogged, "prior.toml");
  experiment.threads = 1;
  const TrainingResult result = train(experiment, logs, logs, {});
  EXPECT_LT(result.validation_rmse, 0.12) << "the sensor has .3; the effect of the input is known";
  const auto& prior = std::get<codegen::Prior>(result.model.structure);
  EXPECT_EQ(prior.equations.derivative, std::vector<std::string>{"a - 0.1 * v"});
  const auto refused = [](std::string text, const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
    return thrown_message([&] { parse_experiment(text, "prior.toml"); });
  };
  EXPECT_NE(refused(kLogged, "output_names = [\"y\"]", "output_names = [\"x\"]").find("[plant]"), std::string::npos);
  EXPECT_NE(refused(kLogged, "share = 0.0", "share = 0.2").find("the input \"w\""), std::string::npos)
      << "simulated runs need every input";
}

// The sensor also measures half of the input. A filter that did not know this would estimate v with this error.
TEST(Prior, PredictsAnOutputThatDependsOnAnInput) {
  Dataset logs = driven_logs(0.0);
  for (Trajectory& run : logs.trajectories) run.outputs += 0.5 * run.inputs.row(1);
  std::string text = kLogged;
  const std::string from = "outputs = [\"v\"]", units = "units = 4";
  text.replace(text.find(units), units.size(), "units = 0");
  const auto rmse = [&](const std::string& output) {
    std::string changed = text;
    changed.replace(changed.find(from), from.size(), "outputs = [\"" + output + "\"]");
    Experiment experiment = parse_experiment(changed, "prior.toml");
    experiment.threads = 1;
    const TrainingResult result = train(experiment, logs, logs, {});
    EXPECT_NEAR(result.validation_rmse, testing::reference_rmse(result.model, logs), 1e-3 * result.validation_rmse)
        << "training equals flight, as above";
    return result.validation_rmse;
  };
  const double known = rmse("v + 0.5 * a");
  EXPECT_LT(known, 0.12) << "as above, where no input acts on the sensor";
  EXPECT_GT(rmse("v"), 1.5 * known) << "control";
  std::string simulated = text;
  simulated.replace(simulated.find(from), from.size(), "outputs = [\"v + 0.5 * a\"]");
  const std::string share = "share = 0.0";
  simulated.replace(simulated.find(share), share.size(), "share = 0.2");
  EXPECT_NE(thrown_message([&] { parse_experiment(simulated, "prior.toml"); }).find("a function of the state alone"),
            std::string::npos);
}

TEST(Prior, StepsAStateThatTheLogsDoNotHave) {
  const Dataset logs = driven_logs(0.5);
  const auto changed = [](std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  };
  const std::string filter = changed(kLogged, "units = 4", "units = 0");
  std::string text = changed(filter, "states = [\"v\"]", "states = [\"v\", \"bias\"]\nestimated = [\"v\"]");
  text = changed(text, "[\"a - 0.1 * v\"]", "[\"a - bias - 0.1 * v\", \"0\"]");
  text = changed(text, "[-1.0]", "[-1.0, -0.5]");
  text = changed(text, "[1.0]", "[1.0, 0.5]");
  const auto trained = [&logs](const std::string& experiment_text) {
    Experiment experiment = parse_experiment(experiment_text, "prior.toml");
    experiment.threads = 1;
    return train(experiment, logs, logs, {});
  };
  const TrainingResult with = trained(text), without = trained(filter);
  const auto& prior = std::get<codegen::Prior>(with.model.structure);
  EXPECT_EQ(prior.equations.unestimated, std::vector<std::string>{"bias"});
  EXPECT_LT(prior.state_min(1), -0.5) << "the range has more than the box";
  EXPECT_GT(prior.state_max(1), 0.5);
  EXPECT_NEAR(with.model.initial_latent(1), 0.0, 1e-9) << "the middle of the box";
  // A constant disturbance of .5 that no state holds leaves an error of some .1 in a filter of this bandwidth.
  EXPECT_LT(with.validation_rmse, 0.7 * without.validation_rmse);

  const auto refused = [](const std::string& changed_text) {
    return thrown_message([&] { parse_experiment(changed_text, "prior.toml"); });
  };
  EXPECT_NE(refused(changed(text, "estimated = [\"v\"]", "")).find("(or `estimated`"), std::string::npos)
      << "a state without a column that is to be estimated";
}

// Fails if training keeps the model with the smallest total error although one state has become worse.
TEST(Prior, NeverKeepsAModelThatEstimatesAStateWorseThanItsInitialFilter) {
  const Dataset data = harmonics({60, 90, 75}, false);
  const auto state_errors = [&](int steps) {
    Experiment experiment = prior_experiment("");
    experiment.training.steps = steps;
    experiment.training.learning_rate = 0.3;
    experiment.training.validate_every = 5;
    experiment.inverse_map.readout = ReadoutChoice::kNetwork;
    const codegen::Model model = train(experiment, data, data, {}).model;
    codegen::ReferenceObserver<double> observer(model);
    Eigen::VectorXd squares = Eigen::VectorXd::Zero(2);
    for (const Trajectory& run : data.trajectories)
      squares += (observer.run(run.outputs, {}, run.time_s, data.uniform).x_hat - run.states).rowwise().squaredNorm();
    return squares.cwiseSqrt().eval();
  };
  const Eigen::VectorXd filter = state_errors(0), model = state_errors(60);
  for (Eigen::Index i = 0; i < 2; ++i) EXPECT_LE(model(i), 1.021 * filter(i)) << "1.02 and the rounding of float";
}

TEST(Prior, ReadsBackFromTheModelFile) {
  const Dataset data = harmonics({60, 90}, false);
  for (const int units : {5, 0}) {
    const codegen::Model model = train(prior_experiment("", units), data, data, {}).model;
    const std::string text = codegen::to_json(model);
    EXPECT_EQ(codegen::to_json(codegen::parse_model(text, "model.json")), text);
    EXPECT_EQ(text.find("\"gates\"") != std::string::npos, units > 0);
  }
}

TEST(Prior, WithoutUnitsItIsTheTunedFilterFromWhichTrainingStarts) {
  Dataset data = harmonics({60, 90, 75}, true);
  const auto filter = [&data](int units) {
    Experiment experiment = prior_experiment("", units);
    experiment.inverse_map.hidden = {};
    experiment.inverse_map.readout = ReadoutChoice::kNetwork;
    experiment.training.steps = 0;
    return train(experiment, data, data, {});
  };
  const TrainingResult with = filter(5), without = filter(0);
  EXPECT_EQ(without.model.nz(), 5) << "two states and the triangle of their covariance";
  EXPECT_EQ(without.validation_rmse, with.validation_rmse) << "corrections of zero change no bit";
  const auto& tuned = std::get<codegen::Prior>(with.model.structure);
  const auto& same = std::get<codegen::Prior>(without.model.structure);
  EXPECT_EQ(same.state_noise, tuned.state_noise);
  EXPECT_EQ(same.output_noise, tuned.output_noise);
  EXPECT_NEAR(without.validation_rmse, testing::reference_rmse(without.model, data), 1e-3 * without.validation_rmse)
      << "training equals flight";
}

/// Returns the first variance of the position over that of the velocity, each relative to the variance of the state,
/// after tuning on oscillations of random amplitudes that begin at this phase in every run.
double first_variances(double phase) {
  Dataset data = harmonics(std::vector<int>(8, 120), false);
  std::mt19937 engine(11);
  std::normal_distribution<double> amplitude(0.0, 1.0), noise(0.0, 0.2);
  double squares[2] = {};
  for (Trajectory& run : data.trajectories) {
    const double rate = std::sqrt(3.5), size = amplitude(engine);
    for (Eigen::Index k = 0; k < run.states.cols(); ++k) {
      const double angle = rate * run.time_s(k) + phase;
      run.states.col(k) << size * std::sin(angle), size * rate * std::cos(angle);
      run.outputs(0, k) = run.states(0, k) + noise(engine);
      for (int i = 0; i < 2; ++i) squares[i] += run.states(i, k) * run.states(i, k);
    }
  }
  Experiment experiment = prior_experiment("", 0);
  experiment.inverse_map.hidden = {};
  experiment.inverse_map.readout = ReadoutChoice::kNetwork;
  experiment.training.steps = 0;
  const Eigen::VectorXd z = train(experiment, data, data, {}).model.initial_latent;
  return (z(2) / squares[0]) / (z(4) / squares[1]);
}

TEST(Prior, TuningSetsTheFirstVarianceOfEachStateByItself) {
  EXPECT_LT(first_variances(0.0), 0.1) << "each run begins at position 0, with another velocity";
  EXPECT_GT(first_variances(1.5707963), 10.0) << "each run begins at another position, with velocity 0";
}

TEST(Prior, WithoutUnitsOnlyTheInverseMapLearns) {
  const Dataset data = harmonics({60, 90, 75}, false);
  const TrainingResult result = train(prior_experiment("", 0), data, data, {});
  EXPECT_NEAR(result.validation_rmse, testing::reference_rmse(result.model, data), 1e-3 * result.validation_rmse);
}

TEST(Prior, RefusesRatesWithoutUnits) {
  EXPECT_EQ(thrown_message([] { prior_experiment("rates = [1.0, 2.0]\n", 0); }),
            "prior.toml:13: [observer] rates has no effect without units; remove it");
  EXPECT_EQ(thrown_message([] {
              parse_experiment(
                  "name = \"g\"\n[plant]\nstates = [\"a\"]\nderivative = [\"-a\"]\noutputs = [\"a\"]\n"
                  "[simulation]\ninitial_low = [-1.0]\ninitial_high = [1.0]\n[observer]\n"
                  "structure = \"gated\"\nunits = 0\n",
                  "gated.toml");
            }),
            "gated.toml:11: [observer] units is 0, but a gated observer is made of units; give it at least one, or use "
            "structure = \"prior\", which without units is an extended Kalman filter");
}

TEST(Prior, RefusesPlantsThatItCannotStep) {
  const std::string plant = "name = \"p\"\n[plant]\nstates = [\"a\", \"b\"]\noutputs = [\"a\"]\n";
  const std::string rest =
      "[simulation]\ninitial_low = [-1.0, -1.0]\ninitial_high = [1.0, 1.0]\n[observer]\nstructure = \"prior\"\n";
  EXPECT_NO_THROW(parse_experiment(plant + "derivative = [\"b\", \"-a^3 - b / 2\"]\n" + rest, "a.toml"));
  EXPECT_NO_THROW(parse_experiment(plant + "derivative = [\"b\", \"-sin(a) / (2 + b^2)\"]\n" + rest, "a.toml"));
  const std::string message =
      thrown_message([&] { parse_experiment(plant + "derivative = [\"b\", \"-a ^ b\"]\n" + rest, "a.toml"); });
  EXPECT_NE(message.find("equations.derivative[1]"), std::string::npos) << message;
  EXPECT_NE(message.find("sums, products, quotients, whole powers, functions"), std::string::npos) << message;
}

// Two parsers read the same texts: muParser for the simulation, and the parser for expressions that fly and are
// differentiated.
TEST(Prior, EvaluatesEquationsAsTheSimulatedPlant) {
  const std::vector<std::string> names = {"a", "b"};
  for (const std::string text :
       {"a - b - 2", "a / b * 3", "a / 2 / b", "-a^2", "2 * -b", "a * b^3 - 1e-3", "sin(a) / (2 + cos(b)^2)",
        "tan(a / 3)", "tanh(b / 0.2) + exp(-a)", "ln(2 + a^2) * sqrt(b^2)", "max(a, b, 0) - min(a, b / 2)",
        "atan(3 * a) - abs(b) * sign(b)", "pi * a"}) {
    mu::Parser parser;
    double values[] = {0.7, -1.3};
    compile_expression(parser, text, "a text", {.variables = names}, values);
    const codegen::Expression flying(text, names, codegen::Expression::Language::kFunctions);
    const double value = parser.Eval();
    EXPECT_NEAR(flying.evaluate<double>([&](int j) { return values[j]; }), value, 1e-14 * (1.0 + std::fabs(value)))
        << text;
  }
}

TEST(Prior, StepsAnAngleAsItsSineAndCosine) {
  const std::string pendulum =
      "name = \"p\"\n[plant]\nstates = [\"angle\", \"rate\"]\nderivative = [\"rate\", \"-9 * sin(angle) - 0.1 * "
      "rate\"]\n"
      "outputs = [\"angle\"]\nstate_wraps = [\"2pi\", 0]\noutput_wraps = [\"2pi\"]\n";
  const std::string encoded = "state_encodings = [\"sincos\", \"unwrap\"]\noutput_encodings = [\"sincos\"]\n";
  const std::string rest =
      "[simulation]\nhorizon_s = 4\ntrajectories = 30\ninitial_low = [-3.1, -9.0]\ninitial_high = [3.1, 9.0]\n"
      "[observer]\nstructure = \"prior\"\nunits = 4\n[inverse_map]\nhidden = [8]\nlinear_path = true\n"
      "[training]\nsteps = 120\nlearning_rate = 0.01\ntrajectories_per_step = 8\nsamples_per_step = 1200\n";
  Experiment experiment = parse_experiment(pendulum + encoded + rest, "p.toml");
  experiment.threads = 1;
  const TrainingSets sets = simulate_training_sets(experiment);
  const TrainingResult result = train(experiment, sets.training, sets.validation, {});
  const auto& prior = std::get<codegen::Prior>(result.model.structure);
  EXPECT_EQ(prior.equations.derivative,
            (std::vector<std::string>{"angle_cos * (rate)", "-angle_sin * (rate)", "-9 * angle_sin - 0.1 * rate"}));
  EXPECT_EQ(prior.equations.outputs, (std::vector<std::string>{"angle_sin", "angle_cos"}));
  EXPECT_LT(result.validation_rmse, 2.0) << "for turns at up to 9 rad/s, after a short training";
  // An angle stored as one number would jump.
  EXPECT_NE(thrown_message([&] { parse_experiment(pendulum + rest, "p.toml"); }).find("\"sincos\""), std::string::npos);
}

// A measurement below 0 drives the estimate to a value that the plant cannot have and for which its root is not
// defined.
TEST(Prior, StaysFiniteOutsideTheDomainOfTheEquations) {
  Experiment experiment = parse_experiment(
      "name = \"tank\"\n[plant]\nstates = [\"level\"]\nderivative = [\"0.5 - sqrt(2 * (level + 0))\"]\n"
      "outputs = [\"level\"]\n[simulation]\nhorizon_s = 4\ntrajectories = 30\ninitial_low = [0.05]\n"
      "initial_high = [2.0]\n[observer]\nstructure = \"prior\"\nunits = 2\n[inverse_map]\nhidden = [4]\n"
      "linear_path = true\n[training]\nsteps = 0\nnoise = \"gaussian:0.3\"\n",
      "tank.toml");
  experiment.threads = 1;
  const TrainingSets sets = simulate_training_sets(experiment);
  const codegen::Model model = train(experiment, sets.training, sets.validation, {}).model;
  const auto& prior = std::get<codegen::Prior>(model.structure);
  EXPECT_EQ(prior.equations.derivative, std::vector<std::string>{"0.5 - sqrt(max(2 * (level + 0), 0))"});
  EXPECT_LT(prior.state_min(0), 0.0) << "control: the estimate may fall below 0";
  const Eigen::VectorXd time_s = Eigen::VectorXd::LinSpaced(400, 0.0, 399 * model.sample_period_s);
  const Eigen::MatrixXd low = Eigen::MatrixXd::Constant(1, 400, -100.0);
  const auto run = codegen::ReferenceObserver<float>(model).run(low, {}, time_s, true);
  EXPECT_TRUE(run.x_hat.allFinite());
  EXPECT_LT(run.x_hat.minCoeff(), 0.0) << "control: the estimate fell below 0";
}

/// A spring with friction and a load that nothing drives; its position is measured.
Experiment loaded_spring(const std::string& estimated, const std::string& training) {
  Experiment experiment = parse_experiment(
      "name = \"spring\"\n[plant]\nstates = [\"position\", \"velocity\", \"load\"]\n"
      "derivative = [\"velocity\", \"-4 * position - 0.2 * velocity + load\", \"0\"]\noutputs = [\"position\"]\n" +
          estimated +
          "[simulation]\nhorizon_s = 6\nsample_period_s = 0.05\ntrajectories = 40\ninitial_low = [-1.0, -1.0, -1.0]\n"
          "initial_high = [1.0, 1.0, 1.0]\n[observer]\nstructure = \"prior\"\nunits = 3\n[inverse_map]\n"
          "hidden = [8]\nlinear_path = true\n[training]\nnoise = \"gaussian:0.1\"\n" +
          training,
      "spring.toml");
  experiment.threads = 1;
  return experiment;
}

/// Root mean square error of `state` over the validation runs, under the same noise for each model.
double error_under_noise(const codegen::Model& model, const Dataset& data, const char* state) {
  const auto row = [state](const std::vector<Channel>& states) {
    return std::ranges::find(states, std::string(state), &Channel::name) - states.begin();
  };
  double squares = 0.0, count = 0.0;
  for (std::size_t i = 0; i < data.trajectories.size(); ++i) {
    const Trajectory& run = data.trajectories[i];
    const Eigen::MatrixXd y = MeasurementNoise(parse_noise("gaussian:0.1"), 1, i).on(run.outputs, {});
    const Eigen::MatrixXd x_hat = codegen::ReferenceObserver<double>(model).run(y, {}, run.time_s, true).x_hat;
    squares += (x_hat.row(row(model.states)) - run.states.row(row(data.states))).squaredNorm();
    count += static_cast<double>(run.samples());
  }
  return std::sqrt(squares / count);
}

TEST(Prior, StepsStatesThatItDoesNotEstimate) {
  const std::string none = "steps = 0\n";
  const Experiment some = loaded_spring("estimated = [\"load\", \"velocity\"]\n", none), all = loaded_spring("", none);
  const TrainingSets sets = simulate_training_sets(some), full = simulate_training_sets(all);
  ASSERT_EQ(sets.training.states.size(), 2U);
  const codegen::Model model = train(some, sets.training, sets.validation, {}).model;
  const codegen::Model whole = train(all, full.training, full.validation, {}).model;
  const auto& prior = std::get<codegen::Prior>(model.structure);
  EXPECT_EQ(prior.equations.unestimated, std::vector<std::string>{"position"});
  EXPECT_EQ(prior.equations.derivative,
            (std::vector<std::string>{"0", "-4 * position - 0.2 * velocity + load", "velocity"}));
  ASSERT_EQ(model.nz(), whole.nz()) << "three units, three states and the triangle of their covariance";
  // Both models are the tuned filter, one for two states and one for three.
  for (const char* state : {"velocity", "load"})
    EXPECT_LT(error_under_noise(model, sets.validation, state), 1.03 * error_under_noise(whole, full.validation, state))
        << state;
  const std::string text = codegen::to_json(model);
  EXPECT_EQ(codegen::to_json(codegen::parse_model(text, "model.json")), text);
  const auto refused = [&](const std::string& name) {
    std::string changed = text;
    const std::string from = "\"unestimated\": [\"position\"]";
    changed.replace(changed.find(from), from.size(), "\"unestimated\": [\"" + name + "\"]");
    return thrown_message([&] { codegen::parse_model(changed, "model.json"); });
  };
  EXPECT_NE(refused("load").find("equations.unestimated[0] is \"load\""), std::string::npos);
  EXPECT_NE(refused("1x").find("equations.unestimated[0] is not an identifier"), std::string::npos);
}

TEST(Prior, TrainingEqualsFlightWithStatesThatItDoesNotEstimate) {
  Experiment experiment =
      loaded_spring("estimated = [\"velocity\"]\n",
                    "steps = 40\nlearning_rate = 0.01\ntrajectories_per_step = 8\nsamples_per_step = 600\n");
  experiment.training.noise = {};
  const TrainingSets sets = simulate_training_sets(experiment);
  const TrainingResult result = train(experiment, sets.training, sets.validation, {});
  EXPECT_NEAR(result.validation_rmse, testing::reference_rmse(result.model, sets.validation),
              1e-3 * result.validation_rmse)
      << "as above";
}

}  // namespace
}  // namespace nlo::trainer
