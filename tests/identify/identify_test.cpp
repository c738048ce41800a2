// SPDX-License-Identifier: MIT
#include "trainer/identify/identify.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "codegen/base/error.h"
#include "tests/identify/identified_pendulum.h"
#include "trainer/identify/identification_text.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::pendulum_identification;
using test::pendulum_logs;
using testing::HasSubstr;

const ParameterEstimate& parameter(const IdentificationResult& result, const std::string& name) {
  for (const ParameterEstimate& p : result.parameters)
    if (p.name == name) return p;
  throw codegen::Error("no parameter " + name);
}

IdentificationResult identified(const Identification& identification, const Dataset& logs, int threads = 1,
                                const std::atomic<bool>* stop = nullptr) {
  ThreadPool pool(threads);
  return identify(identification, logs, {}, pool, stop);
}

/// y = a u1 + b u2 + s, where the state s is constant and each segment has its own; 30 samples a segment.
std::string regression(const std::string& deviation, const std::string& parameters = "{ a = 1.0, b = 1.0 }") {
  return R"(name = "line"
[plant]
states = ["s"]
inputs = ["u1", "u2"]
derivative = ["0"]
output_names = ["y"]
outputs = ["s + a * u1 + b * u2"]
parameters = )" +
         parameters + R"(
[identify]
segment_s = 3.0
noise = { y = 0.5 }
initial_state = [0.0]
process_noise = [0.0]
initial_deviation = [)" +
         deviation + R"(]
[log]
sample_period_s = 0.1
train_files = ["a.csv"]
columns = [{ name = "y", role = "output" }, { name = "u1", role = "input" }, { name = "u2", role = "input" },
           { name = "s", role = "state" }]
)";
}

Dataset regression_logs() {
  constexpr Index kSamples = 121;  // four segments and a remainder
  Dataset logs{{{"y", "", 0.0}}, {{"s", "", 0.0}}, 0.1, true, {Trajectory()}};
  logs.inputs = {{"u1", "", 0.0}, {"u2", "", 0.0}};
  Trajectory& run = logs.trajectories[0];
  run.time_s = VectorXd::LinSpaced(kSamples, 0.0, 12.0);
  run.weight = VectorXd::Zero(kSamples);
  run.states = MatrixXd::Zero(1, kSamples);
  std::mt19937 engine(3);
  const auto uniform = [&] { return 2.0 * static_cast<double>(engine()) * 0x1p-32 - 1.0; };
  run.inputs = MatrixXd::NullaryExpr(2, kSamples, uniform);
  run.inputs.row(1) += 0.8 * run.inputs.row(0);
  run.outputs = 3.0 * run.inputs.row(0) - 2.0 * run.inputs.row(1) + MatrixXd::NullaryExpr(1, kSamples, uniform);
  return logs;
}

/// Ordinary least squares on the first 120 samples: coefficients and s^2 (X'X)^-1. If `levels`, each segment also has a
/// constant.
std::pair<VectorXd, MatrixXd> least_squares(const Dataset& logs, bool levels) {
  const Index n = 120;
  MatrixXd x = MatrixXd::Zero(n, levels ? 6 : 2);
  x.leftCols(2) = logs.trajectories[0].inputs.leftCols(n).transpose();
  for (Index k = 0; k < n && levels; ++k) x(k, 2 + k / 30) = 1.0;
  const VectorXd y = logs.trajectories[0].outputs.leftCols(n).transpose();
  const MatrixXd normal = (x.transpose() * x).inverse();
  const VectorXd b = normal * x.transpose() * y;
  return {b, (y - x * b).squaredNorm() / static_cast<double>(n - x.cols()) * normal};
}

TEST(Identify, EqualsLinearRegressionIfTheOutputIsLinear) {
  const Dataset logs = regression_logs();
  for (const bool levels : {false, true}) {
    const auto result = identified(parse_identification(regression(levels ? "1e4" : "0.0"), "line.toml"), logs);
    const auto [b, covariance] = least_squares(logs, levels);
    EXPECT_EQ(result.segments, 4);
    EXPECT_NEAR(result.degrees_of_freedom, levels ? 114.0 : 118.0, 1e-3);
    for (const auto& [name, i] : {std::pair{"a", 0}, std::pair{"b", 1}}) {
      // Forward differences of 1e-7, and levels that their prior deviation of 1e4 hardly limits.
      EXPECT_NEAR(parameter(result, name).value, b[i], 1e-5);
      EXPECT_NEAR(parameter(result, name).standard_error, std::sqrt(covariance(i, i)), 1e-5);
    }
  }
  const auto [with, c1] = least_squares(logs, true);
  const auto [without, c2] = least_squares(logs, false);
  EXPECT_GT((with - without).head(2).cwiseAbs().maxCoeff(), 1e-3) << "control: the levels matter";
}

TEST(Identify, ErrorsBySegmentsEqualThoseOfClusteredResiduals) {
  const Dataset logs = regression_logs();
  const auto result = identified(parse_identification(regression("0.0"), "line.toml"), logs);
  const MatrixXd x = logs.trajectories[0].inputs.leftCols(120).transpose();
  const VectorXd y = logs.trajectories[0].outputs.leftCols(120).transpose();
  const MatrixXd normal = (x.transpose() * x).inverse();
  const VectorXd r = y - x * (normal * x.transpose() * y);
  MatrixXd scatter = MatrixXd::Zero(2, 2);
  for (Index s = 0; s < 4; ++s) {
    const VectorXd gradient = x.middleRows(30 * s, 30).transpose() * r.segment(30 * s, 30);
    scatter += gradient * gradient.transpose();
  }
  const MatrixXd covariance = normal * scatter * normal;
  EXPECT_NEAR(parameter(result, "a").clustered_error, std::sqrt(covariance(0, 0)), 1e-5);
  EXPECT_NEAR(parameter(result, "b").clustered_error, std::sqrt(covariance(1, 1)), 1e-5);
  EXPECT_GT(std::abs(parameter(result, "a").clustered_error - parameter(result, "a").standard_error), 1e-3)
      << "control";
}

TEST(Identify, ErrorsLieWithinTheStandardErrorsOverManyLogs) {
  const Identification identification = pendulum_identification();
  double squares = 0.0, clustered = 0.0, worst = 0.0;
  constexpr int kSeeds = 20;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const auto result = identified(identification, pendulum_logs(seed));
    EXPECT_EQ(result.outcome, "converged");
    EXPECT_NEAR(result.residual_deviation, 1.0, 0.15) << "[identify] noise is the true noise of the logs";
    for (const auto& [name, truth] : {std::pair{"w2", test::kSquare}, std::pair{"c", test::kDamping}}) {
      const ParameterEstimate& p = parameter(result, name);
      const double score = (p.value - truth) / p.standard_error;
      squares += score * score;
      clustered += std::pow((p.value - truth) / p.clustered_error, 2);
      worst = std::max(worst, std::abs(score));
    }
  }
  // 40 squared scores of unit variance: their mean is chi-squared, within .6 and 1.5 with a probability of 98 %.
  EXPECT_GT(squares / (2 * kSeeds), 0.6);
  EXPECT_LT(squares / (2 * kSeeds), 1.5);
  EXPECT_LT(worst, 3.5);
  EXPECT_GT(clustered / (2 * kSeeds), 0.5);  // only four segments, so these errors are rough
}

TEST(Identify, StepsFollowTheTimeStamps) {
  Dataset logs = pendulum_logs(7);
  const auto far = [&] {
    const ParameterEstimate& p = parameter(identified(pendulum_identification(), logs), "w2");
    return std::abs(p.value - test::kSquare);
  };
  const double right = far();
  EXPECT_LT(right, 0.2);
  for (Trajectory& run : logs.trajectories)
    run.time_s = VectorXd::LinSpaced(run.samples(), 0.0, run.time_s[run.samples() - 1]);
  EXPECT_GT(far(), 2.0 * right + 0.1) << "control: even stamps are wrong";
}

TEST(Identify, NamesParametersThatTheLogsDoNotDetermine) {
  const Dataset logs = regression_logs();
  std::string text = regression("0.0", "{ a = 1.0, b = 1.0, d = 2.0 }");
  text.replace(text.find("b * u2"), 6, "b * d * u2");
  const auto apart = identified(parse_identification(text, "line.toml"), logs);
  EXPECT_FALSE(parameter(apart, "a").unidentified);
  EXPECT_TRUE(parameter(apart, "b").unidentified);
  EXPECT_TRUE(parameter(apart, "d").unidentified);
  EXPECT_THAT(to_text(apart), HasSubstr("b, d: the logs do not determine them separately"));
  const auto fixed = identified(parse_identification(text, "line.toml", {"identify.fixed=[\"d\"]"}), logs);
  EXPECT_FALSE(parameter(fixed, "b").unidentified) << "control";
  EXPECT_NEAR(parameter(fixed, "b").value, -1.0, 0.3);
  EXPECT_EQ(parameter(fixed, "d").value, 2.0);
  EXPECT_TRUE(parameter(fixed, "d").fixed);
}

TEST(Identify, AParameterStaysWithinItsRangeAndReportsWhenItIsAtALimit) {
  const Dataset logs = pendulum_logs(2);
  const auto within = [&](const std::string& range) {
    return parameter(
        identified(pendulum_identification({"plant.parameters.w2=" + range, "identify.positive=[]"}), logs), "w2");
  };
  EXPECT_TRUE(within("[5.0, 15.0]").at_bound);
  EXPECT_LE(within("[5.0, 15.0]").value, 15.0);
  EXPECT_FALSE(within("[5.0, 30.0]").at_bound) << "control";
  EXPECT_NEAR(within("[5.0, 30.0]").value, test::kSquare, 0.3);
  const double free = parameter(identified(pendulum_identification(), logs), "w2").standard_error;
  EXPECT_NEAR(within("[5.0, 30.0]").standard_error, free, 1e-3 * free)
      << "in the unit of the parameter, also if the search uses another scale";
}

TEST(Identify, ThreadsDoNotChangeABit) {
  const Dataset logs = pendulum_logs(5, 3);
  const auto one = identified(pendulum_identification(), logs, 1),
             three = identified(pendulum_identification(), logs, 3);
  EXPECT_EQ(one.values, three.values);
  EXPECT_EQ(one.residual_deviation, three.residual_deviation);
  EXPECT_NE(one.values, identified(pendulum_identification(), pendulum_logs(6, 3)).values) << "control";
}

TEST(Identify, AngleJumpsAreFollowed) {
  Dataset logs = pendulum_logs(4);
  const double before = parameter(identified(pendulum_identification(), logs), "w2").value;
  for (Trajectory& run : logs.trajectories)
    run.outputs =
        run.outputs.unaryExpr([](double angle) { return angle + (angle > 0.0 ? 2.0 * 3.141592653589793 : 0.0); });
  EXPECT_NEAR(parameter(identified(pendulum_identification(), logs), "w2").value, before, 1e-3);
}

TEST(Identify, StopsOnRequest) {
  const std::atomic<bool> stop{true};
  const auto result = identified(pendulum_identification(), pendulum_logs(1), 1, &stop);
  EXPECT_TRUE(result.stopped);
  EXPECT_EQ(parameter(result, "w2").value, 15.0) << "the search has not begun";
}

TEST(Identify, RefusesLogsShorterThanASegmentAndDivergingStartValues) {
  const Dataset logs = pendulum_logs(1);
  EXPECT_THAT([&] { identified(pendulum_identification({"identify.segment_s=100.0"}), logs); },
              testing::ThrowsMessage<codegen::Error>(HasSubstr("segment_s = 100 s is longer than every log")));
  EXPECT_THAT([&] { identified(pendulum_identification({"plant.parameters.c=-1e4"}), logs); },
              testing::ThrowsMessage<codegen::Error>(HasSubstr("the simulation with the start values diverges")));
}

}  // namespace
}  // namespace nlo::trainer
