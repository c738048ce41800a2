// SPDX-License-Identifier: MIT
// Training of gated units: gradients through time agree with finite differences, roll-outs equal flight, and the units
// learn a task that needs memory.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "codegen/model_file/model_file.h"
#include "codegen/replay/reference_observer.h"
#include "tests/support/thrown_message.h"
#include "tests/training/training_testing.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/learn/training/train.h"
#include "trainer/structures/gated_units.h"

namespace nlo::trainer {
namespace {

using testing::harmonics;

/// Three units and two readings, with a random linear functional of z as the loss.
struct Problem {
  int units = 3, length;
  Normalisation readings_by{{0.2, -0.1}, {0.7, 1.4}};
  std::vector<double> theta, readings, latent, cotangent, periods;
  GatedUnits<double> gated{units, readings_by};
  GatedRun<double> run;

  Problem(int samples, bool jittered) : length(samples) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    const auto draw = [&](std::vector<double>& values, std::size_t count) {
      values.resize(count);
      for (double& value : values) value = uniform(random);
    };
    const auto row = static_cast<std::size_t>(length) * kGroup;
    draw(theta, static_cast<std::size_t>(gated.parameters()));
    draw(readings, 2 * row);
    draw(cotangent, 3 * row);
    latent.resize(3 * row);
    if (jittered) {
      draw(periods, row);
      for (double& m : periods) m = 1.0 + 0.8 * m;
    }
    run = {length, readings.data(), latent.data(), cotangent.data(), jittered ? periods.data() : nullptr};
  }

  double loss() {
    gated.prepare(theta.data());
    gated.forward(run);
    double sum = 0.0;
    for (std::size_t i = 0; i < latent.size(); ++i) sum += latent[i] * cotangent[i];
    return sum;
  }
};

double worst_of_gradient(int samples, bool jittered) {
  Problem problem(samples, jittered);
  problem.loss();
  std::vector<double> gradient;
  problem.gated.backward(problem.run, gradient);
  double worst = 0.0, largest = 0.0;
  for (std::size_t p = 0; p < problem.theta.size(); ++p) {
    constexpr double kStep = 1e-5;
    const double centre = problem.theta[p];
    const auto at = [&](double offset) {
      problem.theta[p] = centre + offset;
      return problem.loss();
    };
    // Fourth-order differences: the remaining errors are kStep^4 and the rounding 1e-16 * |loss| / kStep.
    const double expected = (8.0 * (at(kStep) - at(-kStep)) - (at(2.0 * kStep) - at(-2.0 * kStep))) / (12.0 * kStep);
    problem.theta[p] = centre;
    worst = std::fmax(worst, std::fabs(gradient[p] - expected));
    largest = std::fmax(largest, std::fabs(expected));
  }
  EXPECT_GT(largest, 0.1) << "control: there is a gradient";
  return worst / largest;
}

TEST(GatedUnits, GradientsThroughTimeAgreeWithFiniteDifferences) {
  // Lengths within a chunk of 32 samples, at its end, and over several chunks.
  for (const int samples : {1, 2, 32, 33, 75})
    for (const bool jittered : {false, true})
      EXPECT_LT(worst_of_gradient(samples, jittered), 2e-9) << samples << " " << jittered;
}

TEST(GatedUnits, StepsOfOnePeriodEqualRegularSteps) {
  Problem regular(40, false), with_periods(40, false);
  with_periods.periods.assign(static_cast<std::size_t>(with_periods.length) * kGroup, 1.0);
  with_periods.run.periods = with_periods.periods.data();
  std::vector<double> gradient, other;
  EXPECT_NEAR(regular.loss(), with_periods.loss(), 1e-12);
  regular.gated.backward(regular.run, gradient);
  with_periods.gated.backward(with_periods.run, other);
  for (std::size_t p = 0; p < gradient.size(); ++p) ASSERT_NEAR(gradient[p], other[p], 1e-11) << p;
}

Experiment gated_experiment(const std::string& observer, int steps = 60, const std::string& training = "") {
  Experiment experiment = parse_experiment(
      "name = \"g\"\n[plant]\nmodel = \"van_der_pol\"\n[simulation]\ninitial_low = [-1.0, -1.0]\ninitial_high = [1.0, "
      "1.0]\n[observer]\nstructure = \"gated\"\n" +
          observer + "[inverse_map]\nhidden = [8]\n[training]\nsteps = " + std::to_string(steps) +
          "\nlearning_rate = 0.01\ntrajectories_per_step = 8\nsamples_per_step = 600\n" + training,
      "gated.toml");
  experiment.threads = 1;
  return experiment;
}

TEST(Gated, TrainingEqualsFlight) {
  for (const bool jittered : {false, true}) {
    Dataset data = harmonics({60, 90, 75}, jittered);
    if (jittered) data.trajectories[1].time_s.tail(40).array() += 0.3;  // a gap of seven samples
    for (const char* features : {"", "features = \"latent_and_output\"\n"}) {
      const TrainingResult result = train(gated_experiment(std::string("units = 5\n") + features), data, data, {});
      ASSERT_EQ(result.model.nz(), 5);
      // Compared with double: float in the roll-out, and tanh of the runtime.
      EXPECT_NEAR(result.validation_rmse, testing::reference_rmse(result.model, data), 1e-4 * result.validation_rmse)
          << features;
    }
  }
}

TEST(Gated, InitialRatesAreSpreadBetweenTheGivenOnes) {
  const Dataset data = harmonics({60}, false);
  const codegen::Model model = train(gated_experiment("units = 3\nrates = [0.5, 8.0]\n", 1), data, data, {}).model;
  // One optimiser step moves a bias by .01; z and the readings change the rates, with mean zero.
  const Eigen::VectorXd bias = std::get<codegen::Gated>(model.structure).gates.layers[0].bias;
  for (int r = 0; r < 3; ++r)
    EXPECT_NEAR(std::log1p(std::exp(2.0 * bias(r))) / 0.05, 0.5 * std::pow(4.0, r), 0.05 * std::pow(4.0, r)) << r;
}

TEST(Gated, LearnsAVelocityThatOneMeasurementDoesNotDetermine) {
  const Dataset data = harmonics({120, 120, 120, 120}, false);
  const auto error = [&](int steps) {
    Experiment experiment = gated_experiment("units = 8\n", steps);
    experiment.inverse_map.readout = ReadoutChoice::kNetwork;  // a linear row would replace the untrained network
    return train(experiment, data, data, {}).validation_rmse;
  };
  const double untrained = error(1), trained = error(300);
  EXPECT_LT(trained, 0.25 * untrained);
}

TEST(Gated, ClampsTheSameReadingsInTrainingAndFlight) {
  const Dataset data = harmonics({200, 200}, false);
  double low = 1e9, high = -1e9;
  for (const Trajectory& run : data.trajectories) {
    low = std::fmin(low, run.outputs.minCoeff());
    high = std::fmax(high, run.outputs.maxCoeff());
  }
  const auto model = [&](const std::string& noise) {
    return train(gated_experiment("units = 2\n", 2, "noise = \"" + noise + "\"\n"), data, data, {}).model;
  };
  const codegen::Model tails = model("student:0.5:1");
  EXPECT_NEAR(tails.output_min(0), low - (high - low) - 3.0, 1e-5);
  EXPECT_NEAR(tails.output_max(0), high + (high - low) + 3.0, 1e-5);
  EXPECT_GT(std::fabs(model("gaussian:0.5").output_max(0) - tails.output_max(0)), 0.1) << "control";
}

TEST(Gated, ContractsAtTheRateThatItsFileStates) {
  const Dataset data = harmonics({120, 120, 120}, false);
  const auto trained = [&](const std::string& observer) {
    return codegen::parse_model(codegen::to_json(train(gated_experiment(observer, 200), data, data, {}).model),
                                "m.json");
  };
  const codegen::Model model = trained("units = 6\ncontraction = 0.9\n");
  const codegen::Contraction& claim = std::get<codegen::Gated>(model.structure).contraction;
  ASSERT_FALSE(claim.none());
  EXPECT_GT(claim.rate, 0.0);
  EXPECT_TRUE(std::get<codegen::Gated>(trained("units = 6\n").structure).contraction.none());
  // Training has reached the limit: the rows of the coupling add up to 0.9, except for rounding to float.
  const Eigen::MatrixXd coupling = codegen::coupling(std::get<codegen::Gated>(model.structure), model.nz());
  EXPECT_NEAR(coupling.rowwise().sum().maxCoeff(), 0.9, 1e-5);

  // Two runs from any initial values, on the same readings anywhere in their ranges.
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const double share = std::exp(-claim.rate * model.sample_period_s);
  const auto distance = [&](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    return (a - b).cwiseAbs().cwiseQuotient(claim.metric).maxCoeff();
  };
  double largest = 0.0;
  for (int run = 0; run < 50; ++run) {
    codegen::Model one = model, other = model;
    for (Eigen::Index r = 0; r < model.nz(); ++r) {
      one.initial_latent(r) = 2.0 * uniform(random) - 1.0;
      other.initial_latent(r) = 2.0 * uniform(random) - 1.0;
    }
    codegen::ReferenceObserver<double> a(one), b(other);
    double before = distance(one.initial_latent, other.initial_latent);
    for (int k = 0; k < 40; ++k) {
      const Eigen::VectorXd y = model.output_min + uniform(random) * (model.output_max - model.output_min);
      a.step(y, Eigen::VectorXd(0), model.sample_period_s);
      b.step(y, Eigen::VectorXd(0), model.sample_period_s);
      const double after = distance(a.latent(), b.latent());
      // 1e-9: rounding in double, when the distance is almost zero.
      ASSERT_LE(after, share * before + 1e-9) << run << ' ' << k;
      largest = std::max(largest, before > 1e-6 ? after / before : 0.0);
      before = after;
    }
  }
  EXPECT_GT(largest, 0.5 * share) << "control: the claimed rate is not far from the real one";
}

TEST(Gated, GivesTheSameBytesForAnyNumberOfThreads) {
  const Dataset data = harmonics({60, 90, 75, 60, 90, 75, 60, 90, 75, 50}, false);
  Experiment experiment = gated_experiment("units = 5\n", 20, "noise = \"gaussian:0.1\"\n");
  experiment.training.trajectories_per_step = 24;
  const std::string one = codegen::to_json(train(experiment, data, data, {}).model);
  experiment.threads = 2;
  const std::string two = codegen::to_json(train(experiment, data, data, {}).model);
  EXPECT_EQ(one, two);
}

TEST(Gated, RefusesUnusedKeys) {
  const auto message = [](const std::string& line) -> std::string {
    return thrown_message([&] { gated_experiment(line + "\n"); });
  };
  EXPECT_EQ(message("units = 4"), "no error");
  EXPECT_EQ(message("rates = [0.5, 20.0]"), "no error");
  EXPECT_EQ(message("eigenvalues = [-1.0]").find("gated.toml:9: [observer] eigenvalues has no effect"), 0U);
  EXPECT_EQ(message("hold = \"zero_order\"").find("gated.toml:9: [observer] hold has no effect"), 0U);
  EXPECT_EQ(message("start = \"steady\"").find("gated.toml:9: [observer] start is"), 0U);
  EXPECT_EQ(message("features = \"latent_minus_output\"").find("gated.toml:9: [observer] features compares"), 0U);
  EXPECT_EQ(message("rates = [3.0]").find("gated.toml:9: [observer] rates must be the slowest"), 0U)
      << message("rates = [3.0]");
  EXPECT_EQ(message("rates = [3.0, -1.0]").find("gated.toml:9: [observer] rates"), 0U);
  EXPECT_EQ(message("units = 0").find("gated.toml:9: [observer] units"), 0U);
}

}  // namespace
}  // namespace nlo::trainer
