// SPDX-License-Identifier: MIT
// Limits for a stated rate of false alarms, on a linear plant whose observer and noise are known.
#include "trainer/judge/monitor/fit_monitor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "codegen/model_file/validate.h"
#include "codegen/replay/reference_monitor.h"
#include "tests/codegen/example_models.h"
#include "tests/support/thrown_message.h"
#include "trainer/judge/evaluation/evaluate.h"
#include "trainer/judge/monitor/monitor_study.h"
#include "trainer/judge/monitor/sensed_runs.h"

namespace nlo::trainer {
namespace {

using codegen::Monitor;
using codegen::WatchedRun;

TEST(ExceededAtRate, IsTheQuantileOfExponentialBlocks) {
  // P(value > t) = exp(-t); 10,000 blocks in 20 h are 500 an hour, so once an hour is t = log 500.
  std::mt19937 engine(1);
  std::exponential_distribution<double> draw(1.0);
  std::vector<double> values(10000);
  for (double& value : values) value = draw(engine);
  EXPECT_NEAR(exceeded_at_rate(values, 20.0, 1.0), std::log(500.0),
              0.15);  // 50 values above it: standard error 0.14 of t
  // A rate below those in the data: once in 200 h.
  EXPECT_NEAR(exceeded_at_rate(values, 20.0, 0.005), std::log(500.0 / 0.005), 1.2);
}

/// A wave with noise. tiny_model reads it without a model of waves.
SensedRuns waves(std::uint64_t seed, int count, double noise, double bias = 0.0, int samples = 1500) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> draw(0.0, 1.0);
  std::uniform_real_distribution<double> phase(0.0, 6.28);
  SensedRuns runs;
  for (int i = 0; i < count; ++i) {
    Eigen::MatrixXd y(1, samples);
    const double start = phase(engine);
    for (int k = 0; k < samples; ++k) y(0, k) = 0.4 * std::sin(start + 0.03 * k) + noise * draw(engine) + bias;
    runs.outputs.push_back(y);
    runs.inputs.emplace_back();
  }
  return runs;
}

codegen::Model watched_waves(double per_hour) {
  codegen::Model model = codegen::tiny_model();
  const double tau = 40.0 * model.sample_period_s;
  const RunSource limits{[](int chunk) { return waves(100 + static_cast<std::uint64_t>(chunk), 40, 0.1); }, 4};
  model.monitor = fit_monitor(model, waves(1, 20, 0.1), limits, waves(2, 10, 0.0), {}, {per_hour, tau, 1}).monitor;
  return model;
}

std::vector<codegen::WatchedRun> watched(const codegen::Model& model, const SensedRuns& runs) {
  std::vector<codegen::WatchedRun> all;
  for (std::size_t i = 0; i < runs.size(); ++i)
    all.push_back(codegen::watched_run(model, *model.monitor, runs.outputs[i], runs.inputs[i]));
  return all;
}

AlarmCount alarms(const codegen::Model& model, const SensedRuns& runs) {
  return count_alarms(watched(model, runs), model.sample_period_s, model.monitor->windows_s(1));
}

TEST(FitMonitor, GivesAValidMonitorWithTheInnovationsOfItsRuns) {
  const codegen::Model model = watched_waves(1.0);
  codegen::validate(model);
  // A wave is a linear function of its past and of z, so the innovation contains only noise: 0.1, and a little by z.
  EXPECT_GT(model.monitor->deviation(0), 0.1);
  EXPECT_LT(model.monitor->deviation(0), 0.12);
  EXPECT_GT(model.monitor->gate, 3.0);
  EXPECT_LT(model.monitor->gate, 4.0);  // Gaussian noise: 3.48 at .9995
  EXPECT_NEAR(model.monitor->hours, 160 * 36 * 40 * model.sample_period_s / 3600.0, 1e-9);
}

TEST(FitMonitor, FalseAlarmsOnNewRunsHaveTheStatedRate) {
  const double hours = 200 * 1460 * codegen::tiny_model().sample_period_s / 3600.0;
  const double per_hour = 40.0 / hours;  // 40 expected
  const codegen::Model model = watched_waves(per_hour);
  const double count = alarms(model, waves(7, 200, 0.1)).per_hour * hours;
  // Poisson with mean 40, and the same variance again for the limits, which come from fewer runs: three deviations are
  // 27.
  EXPECT_GT(count, 13.0);
  EXPECT_LT(count, 67.0);
}

TEST(FitMonitor, RaisesAnAlarmForDataUnlikeTheTraining) {
  const codegen::Model model = watched_waves(0.1);
  EXPECT_LE(alarms(model, waves(8, 20, 0.1)).seen,
            0.05);  // .02 expected in a sixth of an hour, so one run of 20 may have an alarm
  const AlarmCount noisy = alarms(model, waves(9, 20, 0.2));
  EXPECT_EQ(noisy.seen, 1.0);
  EXPECT_EQ(noisy.most, Alarm::kInnovationVariance);
  // Less noise raises no alarm: the variance falls and the mean of the innovation stays.
  EXPECT_EQ(alarms(model, waves(10, 20, 0.0)).seen, 0.0);
  EXPECT_EQ(alarms(model, waves(11, 20, 0.02)).seen, 0.0);
}

/// Waves of which every fifth sample arrives.
SensedRuns slow_waves(std::uint64_t seed, int count, double noise, double bias = 0.0, int samples = 1500) {
  SensedRuns runs = waves(seed, count, noise, bias, samples);
  for (Eigen::MatrixXd& y : runs.outputs)
    for (Eigen::Index k = 0; k < y.cols(); ++k)
      if (k % 5 != 0) y(0, k) = std::numeric_limits<double>::quiet_NaN();
  return runs;
}

codegen::Model watched_slow_waves() {
  codegen::Model model = codegen::tiny_model();
  model.outputs[0].period_s = 5.0 * model.sample_period_s;
  const double tau = 40.0 * model.sample_period_s;
  const RunSource limits{[](int chunk) { return slow_waves(100 + static_cast<std::uint64_t>(chunk), 40, 0.1); }, 8};
  model.monitor = fit_monitor(model, slow_waves(1, 40, 0.1), limits, slow_waves(2, 10, 0.0), {}, {1.0, tau, 1}).monitor;
  return model;
}

TEST(FitMonitor, AWorkingSlowSensorKeepsTheStatedRateOfAlarms) {
  const codegen::Model model = watched_slow_waves();
  codegen::validate(model);
  const auto samples = static_cast<int>(3600.0 / model.sample_period_s);
  const AlarmCount count = alarms(model, slow_waves(7, 1, 0.1, 0.0, samples));
  EXPECT_LE(count.per_hour, 5.0) << "one alarm is expected; the limits come from a tenth of an hour of runs";
  // The prediction uses the filter's view of the last reading, which is five samples old.
  EXPECT_GT(model.monitor->deviation(0), 0.1);
  EXPECT_LT(model.monitor->deviation(0), 0.2);
}

TEST(FitMonitor, EachDefectOfASlowSensorRaisesAnAlarm) {
  const codegen::Model model = watched_slow_waves();
  constexpr Eigen::Index kFault = 750;
  const auto first_alarm = [&](const auto& change) {
    SensedRuns runs = slow_waves(9, 1, 0.1);
    for (Eigen::Index k = kFault; k < runs.outputs[0].cols(); ++k)
      if (std::isfinite(runs.outputs[0](0, k))) change(runs.outputs[0](0, k));
    const WatchedRun run = watched(model, runs).front();
    for (Eigen::Index k = kFault; k < runs.outputs[0].cols(); ++k)
      if (const Alarm alarm = run.alarms[static_cast<std::size_t>(k)]; alarm != Alarm::kNone)
        return std::pair{alarm, k - kFault};
    return std::pair{Alarm::kNone, Eigen::Index{0}};
  };
  EXPECT_EQ(first_alarm([](double&) {}).first, Alarm::kNone) << "control: a working sensor";
  const auto dead = first_alarm([](double& y) { y = std::numeric_limits<double>::quiet_NaN(); });
  EXPECT_EQ(dead.first, Alarm::kMissing);
  EXPECT_LT(dead.second, 8 + 40) << "missing after 8 samples, then an average over 10";
  EXPECT_NE(first_alarm([](double& y) { y = 0.3; }).first, Alarm::kNone);
  EXPECT_NE(first_alarm([](double& y) { y += 1.0; }).first, Alarm::kNone);
  int sign = 1;
  EXPECT_NE(first_alarm([&](double& y) { y += 0.5 * (sign = -sign); }).first, Alarm::kNone);
}

TEST(FitMonitor, DeadSensorRaisesAnAlarmEvenIfTheGateRejectedFiveOfSixReadingsInTraining) {
  codegen::Model model = codegen::tiny_model();
  SensedRuns logs = waves(100, 40, 0.1);
  for (Eigen::MatrixXd& y : logs.outputs)
    for (Eigen::Index k = 700; k < 736; ++k) y(0, k) += k % 6 == 0 ? 0.0 : 5.0;
  const double tau = 16.0 * model.sample_period_s;
  const FittedMonitor fitted =
      fit_monitor(model, waves(1, 20, 0.1), {[&](int) { return logs; }, 1}, std::nullopt, {}, {1.0, tau, 1});
  EXPECT_THAT(fitted.unwatched, testing::Not(testing::Contains(testing::HasSubstr("missing share"))));
  model.monitor = fitted.monitor;
  const auto missing = [&](const SensedRuns& runs) {
    int count = 0;
    for (const WatchedRun& run : watched(model, runs))
      for (const Alarm alarm : run.alarms) count += alarm == Alarm::kMissing;
    return count;
  };
  EXPECT_EQ(missing(logs), 0) << "missing only because of the gate";
  SensedRuns dead = waves(7, 1, 0.1);
  dead.outputs[0].rightCols(750).setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_GT(missing(dead), 730)
      << "12 samples are three time constants of the shortest average, which then reaches 0.95";
}

/// Fits a monitor to an observer whose error is ten times as large in the first `far` samples.
FittedMonitor far_at_first(Eigen::Index far) {
  const codegen::Model model = codegen::tiny_model();
  const SensedRuns runs = waves(5, 4, 0.1);
  const ObserverRun observer = observer_run(model, true);
  std::vector<FlownRun> trial;
  for (const Eigen::MatrixXd& y : runs.outputs) {
    const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(y.cols(), 0.0, 1.0);
    Eigen::MatrixXd truth = observer(y, {}, time).x_hat.array() + 0.1;
    truth.leftCols(far).array() += 0.9;
    trial.push_back({y, {}, truth, Eigen::VectorXd::Ones(y.cols()), {}});
  }
  const RunSource limits{[](int) { return waves(3, 10, 0.1); }, 1};
  const MonitorRequest request{1.0, 40.0 * model.sample_period_s, 1};
  return fit_monitor(model, waves(1, 5, 0.1), limits, std::nullopt, trial, request);
}

/// Returns the number of samples after which this monitor arms.
double armed_after(Eigen::Index far) {
  return far_at_first(far).monitor.armed_after_s / codegen::tiny_model().sample_period_s;
}

TEST(FitMonitor, ArmsWhenTheErrorHasSettledBetweenOneAndThreeTimeConstants) {
  EXPECT_NEAR(armed_after(0), 40.0, 1e-9);
  EXPECT_NEAR(armed_after(70), 70.0, 1e-9);
  EXPECT_NEAR(armed_after(61), 70.0, 1e-9)
      << "averages over quarters: one large sample in ten gives 3.3 times the error";
  EXPECT_NEAR(armed_after(500), 120.0, 1e-9);
}

TEST(FitMonitor, ReportsAnErrorThatHasNotSettledWhenTheMonitorArms) {
  EXPECT_THAT(far_at_first(500).notes, testing::ElementsAre(testing::HasSubstr("the error is still 10 times")));
  EXPECT_THAT(far_at_first(70).notes, testing::IsEmpty());
}

/// Runs of tiny_model with these readings. The truth is its own estimate, so that the error is due to lost readings.
std::vector<FlownRun> own_runs(const codegen::Model& model, const SensedRuns& readings) {
  std::vector<FlownRun> runs;
  for (const Eigen::MatrixXd& y : readings.outputs)
    runs.push_back({y,
                    {},
                    codegen::ReferenceObserver<float>(model).run(y, {}, {}, true).x_hat,
                    Eigen::VectorXd::Ones(y.cols()),
                    {}});
  return runs;
}

/// Readings of a plant that rests at 0, where the observer also starts, until sample `moves`, and then is at 1.5 with
/// small waves.
SensedRuns accelerating(std::uint64_t seed, Eigen::Index moves) {
  SensedRuns runs = waves(seed, 12, 0.01);
  for (Eigen::MatrixXd& y : runs.outputs) {
    y.leftCols(moves) *= 0.1;
    y.rightCols(y.cols() - moves).array() += 1.5;
  }
  return runs;
}

/// The runs of own_runs() with an error of the settled estimate of `error`.
std::vector<FlownRun> inexact_runs(const codegen::Model& model, const SensedRuns& readings, double error) {
  std::vector<FlownRun> runs = own_runs(model, readings);
  std::mt19937_64 engine(17);
  std::normal_distribution<double> draw(0.0, error);
  for (FlownRun& run : runs)
    for (double& x : run.states.reshaped()) x += draw(engine);
  return runs;
}

struct ArmedError {
  double armed_after = 0.0;  ///< [samples]
  double restart = 0.0;      ///< rms error in the quarter of a time constant after arming, divided by the settled one
  double start = 0.0;        ///< the same at starts of the runs
};

/// Fits a monitor to plants that start to move at sample `moves`, and flies it on new runs, from their starts and from
/// restarts at samples 600 and 900, with settled errors of size `error`.
ArmedError armed_error(Eigen::Index moves, double error) {
  constexpr Eigen::Index kBlock = 40, kQuarter = 10;
  codegen::Model model = codegen::tiny_model();
  const RunSource limits{[&](int) { return accelerating(3, moves); }, 1};
  const MonitorRequest request{1.0, kBlock * model.sample_period_s, 1};
  const Monitor monitor = fit_monitor(model, accelerating(1, moves), limits, std::nullopt,
                                      inexact_runs(model, accelerating(5, moves), error), request)
                              .monitor;
  ErrorSum restart, start, settled;
  const std::vector<FlownRun> fresh = inexact_runs(model, accelerating(7, moves), error);
  const Eigen::VectorXd one = Eigen::VectorXd::Ones(model.nx());
  const auto fly_from = [&](const FlownRun& run, ErrorSum& sum) {
    const WatchedRun flown = fly(model, without_gate(monitor), run);
    sum += error_sum(model, run, flown.run.x_hat, one, flown.armed_after, flown.armed_after + kQuarter);
    return flown;
  };
  ArmedError found;
  for (const FlownRun& run : fresh) {
    const WatchedRun whole = fly_from(run, start);
    settled += error_sum(model, run, whole.run.x_hat, one, run.samples() / 2);
    for (const Eigen::Index first : {600, 900}) (void)fly_from(run.from(first), restart);
    found.armed_after = whole.armed_after;
  }
  found.restart = restart.rms() / settled.rms();
  found.start = start.rms() / settled.rms();
  return found;
}

TEST(FitMonitor, ArmsAfterARestartInFlightOnlyWhenTheErrorHasSettled) {
  const ArmedError late = armed_error(300, 0.02);
  EXPECT_LT(late.restart, 2.2) << "2 is the rule; other runs differ by a tenth";
  EXPECT_LT(late.start, 1.2) << "starts alone would arm after 40 samples";
  EXPECT_GT(late.armed_after, 60.0);
  EXPECT_LT(late.armed_after, 250.0) << "the slowest mode has a time constant of 50 samples";
  const ArmedError later = armed_error(300, 0.002);
  EXPECT_GT(later.armed_after, 120.0) << "more than three time constants";
  EXPECT_LT(later.restart, 2.2);
  const ArmedError control = armed_error(300, 0.5);
  EXPECT_NEAR(control.armed_after, 40.0, 1e-9) << "control: the settled error hides the transient of a restart";
  EXPECT_LT(control.restart, 2.2);
}

/// Runs of failing_model. Its second output may be missing; it rests at 2 for half of the time, then moves, and repeats
/// a reading 20 times once in 440 samples. The first output moves when the second does.
SensedRuns resting_runs() {
  std::mt19937_64 engine(1);
  std::normal_distribution<double> draw(0.0, 0.01);
  SensedRuns runs;
  for (int i = 0; i < 4; ++i) {
    Eigen::MatrixXd y(2, 2200), u(2, 2200);
    for (Eigen::Index k = 0; k < y.cols(); ++k) {
      const Eigen::Index at = k % 440;
      for (Eigen::Index j = 0; j < 2; ++j) {
        y(j, k) = (j == 1 || at < 220 ? 1.0 : 3.0) + draw(engine);
        u(j, k) = draw(engine);
      }
      if (at < 220) y(1, k) = 2.0;
      if (at > 419) y(1, k) = y(1, k - 1);
    }
    runs.outputs.push_back(y);
    runs.inputs.push_back(u);
  }
  return runs;
}

TEST(FitMonitor, ASensorIsFrozenIfItRepeatsAReadingLongerThanInTraining) {
  const codegen::Model model = codegen::failing_model();
  ASSERT_EQ(model.failures.outputs, std::vector<int>{1});
  const SensedRuns runs = resting_runs();
  const RunSource limits{[&](int) { return runs; }, 1};
  const MonitorRequest request{1.0, 40.0 * model.sample_period_s, 1};
  const Monitor monitor = fit_monitor(model, runs, limits, std::nullopt, {}, request).monitor;
  // 20 of 440 samples repeat a reading other than the resting one. At most 3 % of all samples may be treated as frozen:
  // the last 13 of the 20 are 2.95 %, and 14 would be 3.2 %.
  EXPECT_EQ(monitor.most_equal(1), 8.0);
  EXPECT_EQ(monitor.resting(1), 2.0);
  EXPECT_EQ(monitor.reference_sensor(1), 0.0) << "it goes to 3 when the other output leaves its rest";
  EXPECT_GT(monitor.rest_min(1), 0.9);
  EXPECT_LT(monitor.rest_max(1), 1.1);
  EXPECT_EQ(monitor.most_equal(0), 5.0) << "a sensor of high resolution, which never repeats a reading";
  EXPECT_EQ(fit_monitor(model, runs, limits, runs, {}, request).monitor.most_equal(1), 0.0)
      << "simulated runs do not show the resolution of a sensor";
  SensedRuns without = runs;
  for (Eigen::MatrixXd& y : without.outputs) y.row(0).setOnes();
  EXPECT_EQ(fit_monitor(model, without, limits, std::nullopt, {}, request).monitor.reference_sensor(1), 1.0)
      << "control: no reference sensor";
}

TEST(FitMonitor, ReplacesLostReadingsIfThePredictionIsBetterThanTheLastReading) {
  const codegen::Model model = codegen::tiny_model();
  const MonitorRequest request{1.0, 40.0 * model.sample_period_s, 1};
  SensedRuns waves;
  for (int i = 0; i < 12; ++i) {
    Eigen::MatrixXd y(1, 1500);
    for (int k = 0; k < y.cols(); ++k) y(0, k) = 0.4 * std::sin(0.2 * k + i);
    waves.outputs.push_back(y);
    waves.inputs.emplace_back();
  }
  const std::vector<FlownRun> runs = own_runs(model, waves);
  const FittedMonitor fitted = fit_monitor(model, waves, {[&](int) { return waves; }, 1}, std::nullopt, runs, request);
  EXPECT_TRUE(fitted.monitor.replaces_any());
  ASSERT_TRUE(fitted.gate.replacing);
  EXPECT_LT(fitted.gate.replacing->cost(), 0.3) << "a wave is nearly known one sample ahead";

  ThreadPool pool(1);
  Monitor wrong = fitted.monitor;
  wrong.replaces.resize(0);
  wrong.offset.array() += 0.3;  // the wave moves by at most 0.08 in a sample
  EXPECT_GT(replace_lost_readings(model, wrong, runs, pool)->cost(), 1.0);
  EXPECT_FALSE(wrong.replaces_any()) << "control: predictions that are far off";
  codegen::Model failing = model;
  failing.failures.outputs = {0};
  EXPECT_FALSE(replace_lost_readings(failing, wrong, runs, pool)) << "the observer expects it to be missing";
}

TEST(FitMonitor, IsTheSameForAnyNumberOfThreads) {
  codegen::Model model = codegen::tiny_model();
  const double tau = 40.0 * model.sample_period_s;
  const RunSource limits{[](int) { return waves(3, 10, 0.1); }, 1};
  const Monitor one = fit_monitor(model, waves(1, 5, 0.1), limits, std::nullopt, {}, {1.0, tau, 1}).monitor;
  const Monitor three = fit_monitor(model, waves(1, 5, 0.1), limits, std::nullopt, {}, {1.0, tau, 3}).monitor;
  EXPECT_EQ(one.mean_limit, three.mean_limit);
  EXPECT_EQ(one.correlation_limit, three.correlation_limit);
  EXPECT_EQ(one.prediction, three.prediction);
}

TEST(FitMonitor, RefusesTooFewSamples) {
  const codegen::Model model = codegen::tiny_model();
  const RunSource none{[](int) { return waves(3, 1, 0.1, 0.0, 50); }, 1};
  const auto message = [&](const SensedRuns& fit, const RunSource& limits) -> std::string {
    return thrown_message([&] {
      (void)fit_monitor(model, fit, limits, std::nullopt, {}, {1.0, 40.0 * model.sample_period_s, 1});
    });
  };
  EXPECT_THAT(message(waves(1, 5, 0.1), none), testing::HasSubstr("too few to set limits; give longer runs"));
  EXPECT_THAT(message(waves(1, 1, 0.1, 0.0, 20), none), testing::HasSubstr("samples are too few for a monitor"));
}

/// 100 samples at 10 Hz, armed after 10 samples, with alarms at the given samples.
WatchedRun run(const std::vector<int>& at) {
  WatchedRun made;
  made.alarms.assign(100, Alarm::kNone);
  for (const int k : at) made.alarms[static_cast<std::size_t>(k)] = Alarm::kInnovationMean;
  made.armed_after = 10;
  return made;
}

TEST(AlarmCount, AlarmsWithinATimeConstantCountAsOne) {
  // Time constant 1 s, 10 samples. Samples 20, 25 and 34 are one alarm, 60 another; 5 comes before the monitor is
  // armed.
  const AlarmCount count = count_alarms({run({5, 20, 25, 34, 60}), run({})}, 0.1, 1.0);
  EXPECT_DOUBLE_EQ(count.per_hour, 2.0 / (2 * 90 * 0.1 / 3600.0));
  EXPECT_DOUBLE_EQ(count.seen, 0.5);
  EXPECT_DOUBLE_EQ(count.median_delay_s.value(), 1.0);
  EXPECT_EQ(count.most, Alarm::kInnovationMean);
}

TEST(AlarmCount, SeenMeansAnAlarmWithinFiveTimeConstants) {
  EXPECT_DOUBLE_EQ(count_alarms({run({60})}, 0.1, 1.0).seen, 1.0);  // 5.0 s after being armed
  EXPECT_DOUBLE_EQ(count_alarms({run({61})}, 0.1, 1.0).seen, 0.0);
  EXPECT_FALSE(count_alarms({run({})}, 0.1, 1.0).median_delay_s);
}

TEST(TimeConstant, IsThatOfTheSlowestModeExceptClocks) {
  // rig_model: pairs at -40 and -25, real modes at -60 and -15 [1/s]; the clock at -2 reads no output.
  const codegen::Model model = codegen::rig_model();
  const TimeConstant own = time_constant(model, {}, false);
  EXPECT_DOUBLE_EQ(own.seconds, 1.0 / 15.0);
  EXPECT_EQ(own.note, "");
}

TEST(TimeConstant, IsThePeriodOfTheOutputsForOtherStructures) {
  const codegen::Model model = codegen::gated_model();
  ASSERT_EQ(codegen::linear_latent(model), nullptr);
  const double period_s = 200.0 * model.sample_period_s;
  SensedRuns runs;
  std::mt19937 engine(1);
  std::normal_distribution<double> noise(0.0, 0.5);
  for (int i = 0; i < 4; ++i) {
    Eigen::MatrixXd y(model.ny(), 2000);
    for (Eigen::Index k = 0; k < y.cols(); ++k)
      y.col(k).setConstant(3.0 + std::sin(2.0 * std::numbers::pi * static_cast<double>(k) / 200.0 + i) + noise(engine));
    runs.outputs.push_back(y);
    runs.inputs.emplace_back();
  }
  // The integral of cos from 0 to a quarter period is 1 / (2 pi) of the period. Noise is uncorrelated from lag 1 on. A
  // sum instead of the integral, and 2,000 samples of a wave of 200, cost a few percent.
  const TimeConstant whole = time_constant(model, runs, false);
  EXPECT_NEAR(whole.seconds, period_s, 0.06 * period_s);
  EXPECT_EQ(whole.note, "");
  // A run has only five periods: the monitor would arm after a fifth of it.
  for (Eigen::MatrixXd& y : runs.outputs) y.conservativeResize(Eigen::NoChange, 1000);
  const TimeConstant shorter = time_constant(model, runs, false);
  EXPECT_DOUBLE_EQ(shorter.seconds, 125.0 * model.sample_period_s);
  EXPECT_THAT(shorter.note, testing::HasSubstr("the longest run has"));
}

/// Runs of rig_model with zero outputs, each of `samples` sample periods.
SensedRuns silent_runs(const codegen::Model& model, int count, Eigen::Index samples) {
  SensedRuns runs;
  for (int i = 0; i < count; ++i) {
    runs.outputs.push_back(Eigen::MatrixXd::Zero(model.ny(), samples));
    runs.inputs.emplace_back();
  }
  return runs;
}

TEST(TimeConstant, SpansSixteenSamplesAtLeast) {
  codegen::Model model = codegen::rig_model();
  model.sample_period_s = 1.0 / 150.0;  // ten samples in the 1/15 s of the slowest mode
  const TimeConstant chosen = time_constant(model, {}, false);
  EXPECT_DOUBLE_EQ(chosen.seconds, 16.0 / 150.0);
  EXPECT_THAT(chosen.note, testing::HasSubstr("they must span at least 16 samples"));
}

TEST(TimeConstant, IsHalvedUntilShortLogsHoldThirtyOfThem) {
  codegen::Model model = codegen::rig_model();
  model.sample_period_s = 1.0 / 1500.0;  // 100 samples in the 1/15 s of the slowest mode
  // Ten logs of 400 samples: after the first block of 100 samples each has 3 more, 30 in all.
  EXPECT_DOUBLE_EQ(time_constant(model, silent_runs(model, 10, 400), true).seconds, 1.0 / 15.0);
  // One sample less: 7 blocks of 50 samples each.
  const TimeConstant halved = time_constant(model, silent_runs(model, 10, 399), true);
  EXPECT_DOUBLE_EQ(halved.seconds, 0.5 / 15.0);
  EXPECT_THAT(halved.note, testing::HasSubstr("limits need 30 time constants of logs"));
  EXPECT_DOUBLE_EQ(time_constant(model, silent_runs(model, 10, 99), false).seconds, 1.0 / 15.0)
      << "simulated runs can be longer";
  EXPECT_DOUBLE_EQ(time_constant(model, silent_runs(model, 1, 99), true).seconds, 16.0 / 1500.0);
}

}  // namespace
}  // namespace nlo::trainer
