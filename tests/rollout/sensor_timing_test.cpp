// SPDX-License-Identifier: MIT
// Timing of sensors in training: late measurements, jitter, and missing samples.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "trainer/rollout/rollout.h"

namespace nlo::trainer {
namespace {

/// A latent system without a state: the tests read only the readings.
class NoLatent final : public LatentDynamics {
 public:
  NoLatent() : LatentDynamics(1) {}
  void prepare(const float*) override {}
  void forward(SegmentGroup&, int) override {}
  void backward(SegmentGroup&, int) override {}
};

constexpr int kRuns = 16, kSamples = 401;

/// Two outputs and an input, all equal to the same function of the sample number.
Dataset signals(const std::function<double(double)>& of_sample) {
  Dataset data;
  data.outputs = {{"a", "", 0.0}, {"b", "", 0.0}};
  data.states = {{"x", "", 0.0}};
  data.inputs = {{"u", "", 0.0}};
  data.reads_inputs = true;
  data.sample_period_s = 0.01;
  Eigen::RowVectorXd signal(kSamples);
  for (int k = 0; k < kSamples; ++k) signal(k) = of_sample(k);
  for (int r = 0; r < kRuns; ++r) {
    Trajectory run;
    run.time_s = Eigen::VectorXd::LinSpaced(kSamples, 0.0, 0.01 * (kSamples - 1));
    run.outputs = signal.replicate(2, 1);
    run.inputs = signal;
    run.states = Eigen::MatrixXd::Zero(1, kSamples);
    run.weight = Eigen::VectorXd::Ones(kSamples);
    data.trajectories.push_back(std::move(run));
  }
  return data;
}

double ramp(double k) {
  return k;
}
double still(double) {
  return 1.0;
}

struct Disturbed {
  std::string noise = "none", input_noise = "none";
  codegen::SensorFailures failures = {};
  int start = 0, threads = 2;
};

/// Returns reading number `row`, of each run (rows) at each sample (columns).
Eigen::MatrixXd reading(const Dataset& dataset, int row, const Disturbed& how) {
  const TrainingData data(dataset, how.failures);
  Rollout rollout(data);
  NoLatent latent;
  ThreadPool pool(how.threads);
  std::vector<Segment> segments = whole_runs(data);
  for (Segment& segment : segments) {
    segment.start = how.start;
    segment.length -= how.start;
  }
  rollout.run(segments, latent, parse_noise(how.noise), 1, Purpose::kNoise, 0, pool, parse_noise(how.input_noise));
  Eigen::MatrixXd all(kRuns, kSamples - how.start);
  for (int r = 0; r < kRuns; ++r)
    for (int t = 0; t < all.cols(); ++t) {
      const SegmentGroup& group = rollout.groups()[static_cast<std::size_t>(r / kGroup)];
      all(r, t) = static_cast<double>(group.readings[group.at(row, t) + static_cast<std::size_t>(r % kGroup)]);
    }
  return all;
}

TEST(SensorTiming, ADelayedSinusoidIsTheSinusoidAtAnEarlierTime) {
  constexpr double kPerSample = 2.0 * 3.14159265358979 / 25.0, kDelay = 2.5;
  const auto wave = [&](double k) { return std::sin(kPerSample * k); };
  const Eigen::MatrixXd y = reading(signals(wave), 0, {.noise = "none+delay:2.5"});
  constexpr double kCubic =
      2e-4;  // cubic interpolation of this sinusoid half way between samples: 3 / 128 (2 pi / 25)^4 = 9e-5
  for (int k = 5; k < kSamples; ++k) ASSERT_NEAR(y(3, k), wave(k - kDelay), kCubic) << k;
  EXPECT_EQ(y(3, 0), 0.0) << "before a run, y has its first value";
  EXPECT_EQ(y(3, 2), 0.0);
  EXPECT_GT(std::abs(y(3, 24) - wave(24)), 0.1) << "control: without the delay the value differs";
}

TEST(SensorTiming, ADelayReachesIntoThePastOfASegment) {
  const Eigen::MatrixXd y = reading(signals(ramp), 1, {.noise = "none,none+delay:7.25", .start = 100});
  EXPECT_NEAR(y(0, 0), 92.75, 1e-4);
  EXPECT_EQ(reading(signals(ramp), 0, {.noise = "none,none+delay:7.25", .start = 100})(0, 0), 100.0);
}

TEST(SensorTiming, ADelayRangeIsDrawnOnceForEachRun) {
  const Eigen::MatrixXd y = reading(signals(ramp), 0, {.noise = "none+delay:1:3"});
  const Eigen::VectorXd delay = 200.0 - y.col(200).array();
  EXPECT_GE(delay.minCoeff(), 1.0);
  EXPECT_LE(delay.maxCoeff(), 3.0);
  EXPECT_GT(delay.maxCoeff() - delay.minCoeff(), 0.5);
  EXPECT_LE((300.0 - y.col(300).array() - delay.array()).abs().maxCoeff(), 1e-4) << "one delay for the whole run";
}

TEST(SensorTiming, JitterIsUniformAndShiftsAllSensorsTogether) {
  const Eigen::MatrixXd inner = reading(signals(ramp), 0, {.noise = "none+jitter:0.3"}).block(0, 1, kRuns, 399);
  Eigen::ArrayXXd off = inner.array();
  for (int k = 0; k < off.cols(); ++k) off.col(k) -= k + 1;
  const auto count = static_cast<double>(off.size());
  EXPECT_LE(off.abs().maxCoeff(), 0.3 + 1e-4);
  EXPECT_NEAR(off.mean(), 0.0, 4.0 * 0.3 / std::sqrt(3.0 * count));
  EXPECT_NEAR(off.square().mean(), 0.03, 4.0 * 0.09 * std::sqrt(4.0 / 45.0 / count));
  EXPECT_EQ(reading(signals(ramp), 0, {.noise = "none+jitter:0.3"}),
            reading(signals(ramp), 1, {.noise = "none+jitter:0.3"}));
}

TEST(SensorTiming, MissingSamplesHaveTheirShareAndBurstLengthAndAreHeld) {
  for (const auto& [noise, in_a_row] : {std::pair{"none+missing:0.2:5", 5.0}, {"none+missing:0.2", 1.25}}) {
    const Eigen::MatrixXd y = reading(signals(ramp), 0, {.noise = noise});
    double missing = 0.0, bursts = 0.0;
    for (int r = 0; r < kRuns; ++r) {
      ASSERT_EQ(y(r, 0), 0.0) << "the first sample always arrives";
      for (int k = 1; k < kSamples; ++k) {
        const bool held = y(r, k) == y(r, k - 1);
        ASSERT_TRUE(held || y(r, k) == k);
        missing += held ? 1.0 : 0.0;
        bursts += held && (k == 1 || y(r, k - 1) == k - 1) ? 1.0 : 0.0;
      }
    }
    // 6,400 samples with about 250 bursts, whose lengths have a standard deviation of about their mean: four standard
    // errors.
    EXPECT_NEAR(missing / 6400.0, 0.2, 0.07) << noise;
    EXPECT_NEAR(missing / bursts, in_a_row, 0.28 * in_a_row) << noise;
  }
  EXPECT_EQ(reading(signals(ramp), 0, {})(0, 100), 100.0) << "control: without the noise no sample is missing";
}

TEST(SensorTiming, StuckAndDeadSamplesHaveTheirShareAndBurstLengthAndCountAsMeasured) {
  codegen::SensorFailures failures;
  failures.outputs = {0};
  failures.rest = Eigen::VectorXd::Constant(1, -4.0);
  failures.staleness_s = 0.05;
  for (const std::string kind : {"stuck", "dead"}) {
    const Disturbed how{.noise = "none+" + kind + ":0.2:5", .failures = failures};
    const Eigen::MatrixXd y = reading(signals(ramp), 0, how);
    EXPECT_TRUE((reading(signals(ramp), 3, how).array() == 0.0).all()) << kind << ": the observer does not know";
    double out = 0.0, bursts = 0.0;
    for (int r = 0; r < kRuns; ++r)
      for (int k = 1; k < kSamples; ++k) {
        if (y(r, k) == k) continue;
        ASSERT_EQ(y(r, k), kind == "dead" ? 0.0 : y(r, k - 1)) << kind;
        out += 1.0;
        bursts += k == 1 || y(r, k - 1) == k - 1 ? 1.0 : 0.0;
      }
    // Four standard errors, as for missing samples.
    EXPECT_NEAR(out / 6400.0, 0.2, 0.07) << kind;
    EXPECT_NEAR(out / bursts, 5.0, 1.4) << kind;
  }
}

TEST(SensorTiming, ABiasCanBeCommonToSensorsAndReadingsCanBeClipped) {
  const std::string noise = "none+common_bias:0.5";
  const Eigen::MatrixXd a = reading(signals(still), 0, {.noise = noise}),
                        b = reading(signals(still), 1, {.noise = noise});
  EXPECT_EQ(a, b) << "one draw for all sensors";
  EXPECT_NE(a(0, 0), a(1, 0)) << "each run has another draw";
  EXPECT_EQ(a(0, 0), a(0, kSamples - 1));
  EXPECT_LE((a.array() - 1.0).abs().maxCoeff(), 0.5);
  const Eigen::MatrixXd clipped = reading(signals(ramp), 0, {.noise = "none+clipped:7"});
  for (int k = 0; k < kSamples; ++k) ASSERT_EQ(clipped(3, k), std::min(k, 7));
}

TEST(SensorTiming, AMissingSampleOfASensorThatMayFailFadesAndItsStalenessGrows) {
  codegen::SensorFailures failures;
  failures.outputs = {1};
  failures.rest = Eigen::VectorXd::Constant(1, -4.0);
  failures.staleness_s = 0.05;
  const Disturbed how{.noise = "none,none+missing:0.3", .failures = failures};
  const Eigen::MatrixXd y = reading(signals(still), 1, how), stale = reading(signals(still), 3, how);
  const double keep = std::exp(-0.01 / 0.05);
  int faded = 0;
  for (int k = 1; k < kSamples; ++k) {
    if (y(0, k) == 1.0) continue;
    ++faded;
    ASSERT_NEAR(y(0, k), -4.0 + keep * (y(0, k - 1) + 4.0), 1e-5) << k;
    ASSERT_NEAR(stale(0, k), 1.0 - keep * (1.0 - stale(0, k - 1)), 1e-5) << k;
  }
  EXPECT_GT(faded, 60);
  EXPECT_TRUE((reading(signals(still), 0, how).array() == 1.0).all());
}

TEST(SensorTiming, DoesNotChangeTheNoise) {
  constexpr double kFloat = 1e-5;  // error of a cubic through equal samples in float
  const Eigen::MatrixXd off = reading(signals(still), 0, {.noise = "gaussian:0.5+outliers:0.1:3"}) -
                              reading(signals(still), 0, {.noise = "gaussian:0.5+outliers:0.1:3+delay:1:3+jitter:0.2"});
  EXPECT_LE(off.cwiseAbs().maxCoeff(), kFloat);
}

TEST(SensorTiming, InputsHaveTheirOwnNoise) {
  const Disturbed how{.noise = "gaussian:0.1", .input_noise = "uniform:0.5+quantised:0.25"};
  const Eigen::MatrixXd u = reading(signals(still), 2, how).array() - 1.0;
  EXPECT_LE(u.cwiseAbs().maxCoeff(), 0.5 + 1e-6);
  EXPECT_GT(u.cwiseAbs().mean(), 0.1);
  EXPECT_TRUE(((u * 4.0).array() == (u * 4.0).array().round()).all());
  EXPECT_EQ(reading(signals(still), 1, how), reading(signals(still), 1, {.noise = "gaussian:0.1"}))
      << "the noise of the outputs is unchanged";
  EXPECT_NEAR(reading(signals(ramp), 2, {.input_noise = "none+delay:1.5"})(0, 50), 48.5, 1e-4);
}

TEST(SensorTiming, DoesNotDependOnTheNumberOfThreads) {
  Disturbed how{.noise = "gaussian:0.1+delay:1:3+jitter:0.2+missing:0.1:4", .input_noise = "gaussian:1+missing:0.2"};
  for (int row = 0; row < 3; ++row) {
    how.threads = 1;
    const Eigen::MatrixXd one = reading(signals(ramp), row, how);
    how.threads = 3;
    EXPECT_EQ(one, reading(signals(ramp), row, how));
  }
}

}  // namespace
}  // namespace nlo::trainer
