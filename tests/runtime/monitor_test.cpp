// SPDX-License-Identifier: MIT
// The statistics of nlo/monitor.h compared with closed forms, for innovations that a test sets: with a prediction of
// zero and y = 0 before, the innovation is y divided by its deviation.
#include "nlo/monitor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "tests/runtime/watched_fakes.h"

namespace nlo::monitor_tests {
namespace {

/// Returns the number of samples until the first alarm of this kind; -1: none, or another alarm came first.
int first_alarm(const Model& model, Alarm wanted, double (*y)(int), int samples = 1000) {
  Monitor<Model> monitor(model);
  Fake observer;
  for (int k = 0; k < samples; ++k) {
    const Alarm alarm = seen(monitor, observer, y(k));
    if (alarm != Alarm::kNone) return alarm == wanted ? k : -1;
  }
  return -1;
}

TEST(Monitor, VarianceOfAConstantInnovationRisesExponentially) {
  // v after n innovations of e: 1 + (1 - exp(-n / window)) (e^2 - 1), starting at v = 1. With e = 2 (y = 4) and window
  // 10, the limit 2.5 is exceeded when 1 - exp(-n / 10) > .5: at n = 7. The first sample gives no innovation.
  Model m = quiet_model();
  m.variance_limit[0][0] = 2.5;
  EXPECT_EQ(first_alarm(m, Alarm::kInnovationVariance, [](int) { return 4.0; }), 7);
}

TEST(Monitor, PowerOfTheSmoothedInnovationDetectsErrorsOfEitherSign) {
  // e = sin(k / 20) has mean zero and variance .5; white noise of this variance does not pass the window of 10.
  Model m = quiet_model();
  m.mean_limit[0][0] = 0.5;
  EXPECT_GT(first_alarm(m, Alarm::kInnovationMean, [](int k) { return 2.0 * std::sin(k / 20.0); }), 0);
  EXPECT_EQ(first_alarm(m, Alarm::kInnovationMean, [](int k) { return k % 2 == 0 ? 2.0 : -2.0; }), -1);
}

TEST(Monitor, CorrelationDetectsAlternatingInnovations) {
  Model m = quiet_model();
  m.correlation_limit[0][1] = 0.5;
  // e = -1, 1, -1, ...: e e_last = -1, so |r| = 1 - exp(-n / 50) exceeds .5 from n = 35 on; the first two samples give
  // no product.
  EXPECT_EQ(first_alarm(m, Alarm::kInnovationCorrelation, [](int k) { return k % 2 == 0 ? 2.0 : -2.0; }), 36);
}

TEST(Monitor, PredictionIsALinearFunctionOfLatentStateReadingsAndEstimate) {
  Model m = quiet_model();
  m.offset[0] = 0.125;
  m.prediction[0][0] = 0.5;
  m.prediction[0][1] = -0.25;
  m.prediction[0][2] = 2.0;
  Monitor<Model> monitor(m);
  Fake observer;
  observer.z = 3.0;
  observer.y = monitor.usable_outputs(-1.0, observer);
  (void)monitor.watch(observer, Vector<double, 1>{{0.75}});
  EXPECT_EQ(monitor.save().outputs[0].predicted, 0.125 + 0.5 * 3.0 - 0.25 * -1.0 + 2.0 * 0.75);
}

TEST(Monitor, ValuesAtALimitRaiseNoAlarmAndAreNotRejected) {
  Model m = quiet_model();
  m.latent_limit[0] = 1.0;
  Monitor<Model> monitor(m);
  Fake observer;
  observer.z = 1.0;  // one standard deviation: d stays at 1
  for (int k = 0; k < 5; ++k) EXPECT_EQ(seen(monitor, observer, 0.0), Alarm::kNone);
  EXPECT_EQ(monitor.level(), 1.0);
  EXPECT_EQ(monitor.usable_outputs(8.0, observer), 8.0) << "four deviations, with less noise than in training";
  EXPECT_TRUE(std::isnan(monitor.usable_outputs(8.001, observer)));
  auto state = monitor.save();
  state.outputs[0].windows[0].variance = 1.5;  // in the shortest window only
  ASSERT_TRUE(monitor.restore(state));
  EXPECT_EQ(monitor.usable_outputs(9.79, observer), 9.79) << "4.895 of 4 sqrt(1.5) = 4.899 deviations";
  EXPECT_TRUE(std::isnan(monitor.usable_outputs(9.81, observer)));
  (void)monitor.watch(observer, {{0.0}});
  EXPECT_EQ(monitor.save().outputs[0].missing, 0) << "no missing sample";
}

/// Returns for each of these measurements whether the armed gate accepts it.
std::vector<bool> accepted(const Model& model, const std::vector<double>& measurements) {
  Monitor<Model> monitor(model);
  Fake observer;
  for (int k = 0; k <= kArmedAfter; ++k) (void)seen(monitor, observer, 0.01 * (k + 1));
  std::vector<bool> through;
  for (const double y : measurements) {
    const double kept = monitor.usable_outputs(y, observer);
    through.push_back(!std::isnan(kept));
    if (through.back()) observer.y = kept;
    (void)monitor.watch(observer, Vector<double, 1>{{0.0}});
  }
  return through;
}

TEST(Monitor, ASensorThatRepeatsAReadingForTooLongIsFrozenUntilItMoves) {
  Model m = quiet_model();
  m.most_equal[0] = 3;
  m.resting[0] = m.rest_min[0] = m.rest_max[0] = 0.5;
  EXPECT_THAT(accepted(m, {1.0, 1.0, 1.0, 1.0, 1.0, 1.25, 1.25}),
              ::testing::ElementsAre(true, true, true, false, false, true, true));
  EXPECT_THAT(accepted(m, std::vector<double>(100, 0.5)), ::testing::Each(true)) << "at rest";
  constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(accepted(m, {1.0, 1.0, kMissing, 1.0, 1.0}), ::testing::ElementsAre(true, true, false, true, false))
      << "a missing sample does not count as a movement";
  m.most_equal[0] = 0;
  EXPECT_THAT(accepted(m, std::vector<double>(100, 1.0)), ::testing::Each(true)) << "control";
}

TEST(Monitor, ARestingSensorIsFrozenIfItsReferenceSensorMoves) {
  Wide::Model m{};
  std::fill_n(m.per_deviation, 2, 1.0);
  m.gate_squared = 1e9;
  m.most_equal[0] = 3;
  m.reference_sensor[0] = 1;
  m.rest_min[0] = -0.1;
  m.rest_max[0] = 0.1;
  Monitor<Wide::Model> monitor(m);
  Wide observer;
  const auto accepted = [&](double y, double reference_sensor) {
    const Vector<double, 2> kept = monitor.usable_outputs({{y, reference_sensor}}, observer);
    (void)monitor.watch(observer, {{0.0, 0.0}});
    return !std::isnan(kept[0]);
  };
  for (int k = 0; k < 20; ++k) EXPECT_TRUE(accepted(0.0, k % 2 == 0 ? 0.1 : -0.1)) << "both sensors are at rest";
  for (int k = 1; k <= 5; ++k) EXPECT_EQ(accepted(0.0, 0.11), k < 3) << "the reference sensor moves: " << k;
  EXPECT_FALSE(accepted(0.0, 0.0)) << "a frozen sensor is rejected until it moves";
  EXPECT_TRUE(accepted(0.001, 0.0));
  EXPECT_TRUE(accepted(0.0, 0.0));
  for (int k = 1; k <= 5; ++k)
    EXPECT_EQ(accepted(0.0, -0.11), k < 3) << "also for movements in the other direction: " << k;
  constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(accepted(0.001, 0.0));
  for (int k = 0; k < 20; ++k) EXPECT_TRUE(accepted(0.0, kMissing)) << "a missing reference sensor has no effect";
}

TEST(Monitor, InnovationOfAnAngleIsMeasuredTheShortWayRound) {
  Model m = quiet_model();
  m.prediction[0][1] = 0.0;
  Fake observer;
  observer.own.outputs.wrap[0] = 6.25;
  const auto first_innovation = [&] {
    Monitor<Model> monitor(m);
    observer.y = 0.0;
    (void)seen(monitor, observer, 3.0);
    (void)seen(monitor, observer, -3.0);  // 0.25 forwards, or 6 backwards
    return monitor.save().outputs[0].last;
  };
  EXPECT_EQ(first_innovation(), 0.125) << "deviation 2";
  observer.own.outputs.wrap[0] = 0.0;
  EXPECT_EQ(first_innovation(), -3.0) << "control";
}

TEST(Monitor, DistanceOfTheLatentStateIsSmoothed) {
  Model m = quiet_model();
  m.latent_limit[0] = 2.0;
  Monitor<Model> monitor(m);
  Fake observer;
  observer.z = 1.0;  // one standard deviation: d stays at 1
  for (int k = 0; k < 100; ++k) ASSERT_EQ(seen(monitor, observer, 0.0), Alarm::kNone);
  observer.z = 2.0;  // d goes to 4
  int k = 0;
  while (seen(monitor, observer, 0.0) == Alarm::kNone && k < 100) ++k;
  EXPECT_EQ(k, 4);  // 1 + 3 (1 - exp(-n / 10)) > 2 from n = 4.05 on: the fifth sample
  EXPECT_EQ(monitor.alarm(), Alarm::kLatentDistance);
}

TEST(Monitor, MissingMeasurementsAreCountedAndDoNotCountAsInnovations) {
  Model m = quiet_model();
  m.missing_limit[0] = 0.5;
  m.variance_limit[0][0] = 1.5;
  const auto missing = [](int k) { return k < 20 ? 0.0 : std::numeric_limits<double>::quiet_NaN(); };
  EXPECT_EQ(first_alarm(m, Alarm::kMissing, missing), 20 + 6);  // 1 - exp(-n / 10) > .5 at the seventh sample
}

TEST(Monitor, RejectsOutliers) {
  const Model m = quiet_model();
  Monitor<Model> monitor(m);
  Fake observer;
  std::mt19937 engine(1);
  std::normal_distribution<double> noise(0.0, 2.0);  // one deviation
  for (int k = 0; k < 200; ++k) (void)seen(monitor, observer, noise(engine));
  EXPECT_FALSE(std::isnan(monitor.usable_outputs(7.0, observer)));  // 3.5 deviations
  EXPECT_TRUE(std::isnan(monitor.usable_outputs(40.0, observer)));  // 20
  EXPECT_TRUE(std::isnan(monitor.usable_outputs(-40.0, observer)));
}

TEST(Monitor, GateRejectsNothingBeforeTheMonitorIsArmed) {
  Model m = quiet_model();
  m.armed_after = 30;
  Monitor<Model> monitor(m);
  Fake observer;
  for (int k = 0; k <= m.armed_after; ++k) {
    EXPECT_FALSE(std::isnan(monitor.usable_outputs(1000.0 * (k % 2), observer))) << k;
    (void)seen(monitor, observer, 0.0);
  }
  EXPECT_TRUE(std::isnan(monitor.usable_outputs(1000.0, observer))) << "control: once armed it rejects";
}

TEST(Monitor, GateAcceptsReadingsThatStayFarAway) {
  // After a jump of the true state, all readings look like outliers. The gate rejects at most kMostRejected of them,
  // and no more until a reading is ordinary; a second jump is then rejected again.
  Model m = quiet_model();
  m.armed_after = 30;
  Monitor<Model> monitor(m);
  Fake observer;
  for (int k = 0; k <= m.armed_after; ++k) (void)seen(monitor, observer, 0.0);
  const auto rejected = [&](double y, int samples) {
    int count = 0;
    for (int k = 0; k < samples; ++k) {
      count += std::isnan(monitor.usable_outputs(y, observer));
      observer.y = 0.0;  // a slow observer: the innovation stays large
      (void)monitor.watch(observer, {{0.0}});
    }
    return count;
  };
  EXPECT_EQ(rejected(1000.0, 200), kMostRejected);
  EXPECT_EQ(rejected(0.0, 400), 0) << "ordinary readings, until the variance is ordinary as well";
  EXPECT_EQ(rejected(1000.0, 200), kMostRejected);
}

TEST(Monitor, ReplacesAMissingOrRejectedMeasurementByThePrediction) {
  // The predicted change is -y / 4: -0.125 y deviations of 2 units.
  Model m = quiet_model();
  m.prediction[0][1] = -0.125;
  m.replaces[0] = 1;
  m.armed_after = 30;
  for (const double unusable : {std::numeric_limits<double>::quiet_NaN(), 1000.0}) {
    Monitor<Model> monitor(m);
    Fake observer;
    for (int k = 0; k < 50; ++k) (void)seen(monitor, observer, 8.0 * (k == 49));
    double predicted = 8.0;
    for (int k = 0; k < kMostRejected; ++k) {
      predicted += -0.125 * predicted / m.per_deviation[0];
      const double kept = monitor.usable_outputs(unusable, observer);
      EXPECT_DOUBLE_EQ(kept, predicted) << k << " after " << unusable;
      observer.y = kept;
      (void)monitor.watch(observer, {{0.0}});
    }
    const double next = monitor.usable_outputs(unusable, observer);
    EXPECT_TRUE(std::isnan(unusable) ? std::isnan(next) : next == unusable) << "no sensor for more than kMostRejected";
  }
}

TEST(Monitor, ReplacedMeasurementsCountAsMissing) {
  // The observer's status is kOk, so only this alarm reports it.
  Model m = quiet_model();
  m.replaces[0] = 1;
  m.missing_limit[0] = 0.15;
  Monitor<Model> monitor(m);
  Fake observer;
  for (int k = 0; k < 50; ++k) EXPECT_EQ(seen(monitor, observer, 0.0), Alarm::kNone);
  Alarm last = Alarm::kNone;
  for (int k = 0; k < 50; ++k)
    last = seen(monitor, observer, k % 3 == 0 ? std::numeric_limits<double>::quiet_NaN() : 0.0);
  EXPECT_EQ(last, Alarm::kMissing);
}

TEST(Monitor, ReplacesNothingBeforeItIsArmedOrAfterAGap) {
  // A prediction is for one sample period, and at first z has a transient.
  Model m = quiet_model();
  m.replaces[0] = 1;
  Monitor<Model> monitor(m);
  Fake observer;
  const double missing = std::numeric_limits<double>::quiet_NaN();
  for (int k = 0; k <= kArmedAfter; ++k) {
    (void)seen(monitor, observer, 0.0);
    if (k < kArmedAfter) {
      EXPECT_TRUE(std::isnan(monitor.usable_outputs(missing, observer))) << k;
    }
  }
  EXPECT_TRUE(std::isnan(monitor.usable_outputs(missing, observer, 0.02))) << "two sample periods";
  EXPECT_FALSE(std::isnan(monitor.usable_outputs(missing, observer))) << "control";
}

TEST(Monitor, GateDoesNotCompareAReadingAfterAGapWithThePredictionOfOnePeriod) {
  const Model m = quiet_model();
  Monitor<Model> monitor(m);
  Fake observer;
  for (int k = 0; k < 50; ++k) (void)seen(monitor, observer, 0.0);
  EXPECT_EQ(monitor.usable_outputs(1000.0, observer, 0.02), 1000.0) << "two sample periods";
  EXPECT_TRUE(std::isnan(monitor.usable_outputs(1000.0, observer, 0.014))) << "jitter";
  EXPECT_TRUE(std::isnan(monitor.usable_outputs(1000.0, observer))) << "control";
}

TEST(Monitor, GateRejectsNoLongerThanTheMonitorNeedsToArm) {
  Model m = quiet_model();
  m.armed_after = 2;
  EXPECT_THAT(accepted(m, {1000.0, 1000.0, 1000.0, 1000.0}), ::testing::ElementsAre(false, false, true, true));
}

TEST(Monitor, GateWidensWithTheNoise) {
  // If a sensor is four times as noisy as in training, one reading in 3 is beyond 4 deviations. With a constant gate
  // the observer would lose a third of its readings.
  const Model m = quiet_model();
  Monitor<Model> monitor(m);
  Fake observer;
  std::mt19937 engine(2);
  std::normal_distribution<double> noise(0.0, 8.0);
  int rejected = 0;
  for (int k = 0; k < 5000; ++k) {
    const double y = noise(engine);
    if (k > 100 && std::isnan(monitor.usable_outputs(y, observer))) ++rejected;
    (void)seen(monitor, observer, y);
  }
  EXPECT_LT(rejected, 250);  // 5 %
}

TEST(Monitor, RaisesAnAlarmForMissingReadingsBeforeItIsArmed) {
  Model m = quiet_model();
  m.missing_limit[0] = 0.5;
  m.armed_after = 100;
  Monitor<Model> monitor(m);
  Fake observer;
  observer.reading = StepStatus::kHeld;
  int k = 0;
  while (monitor.watch(observer, {{0.0}}) == Alarm::kNone && k < 100) ++k;
  EXPECT_EQ(k, 6);  // 1 - exp(-n / 10) > .5 at the seventh sample
  EXPECT_EQ(monitor.alarm(), Alarm::kMissing);
  EXPECT_FALSE(monitor.armed());
}

TEST(Monitor, IsNotArmedWhileTheObserverIsStaleAndForItsArmingTimeAfterwards) {
  const Model m = quiet_model();
  Monitor<Model> monitor(m);
  Fake observer;
  for (int k = 0; k < 50; ++k) (void)seen(monitor, observer, 0.0);
  ASSERT_TRUE(monitor.armed());
  observer.reading = StepStatus::kStale;  // a gap, or a sensor that was missing for a long time
  (void)seen(monitor, observer, 0.0);
  EXPECT_FALSE(monitor.armed());
  observer.reading = StepStatus::kOk;
  for (int k = 0; k < kArmedAfter; ++k) (void)seen(monitor, observer, 0.0);
  EXPECT_FALSE(monitor.armed());
  (void)seen(monitor, observer, 0.0);
  EXPECT_TRUE(monitor.armed());
}

TEST(Monitor, ASensorThatRepeatsAReadingWhileThePredictionMovesOnIsFrozen) {
  Model m = quiet_model();
  m.prediction[0][0] = 1.0;  // z predicts the change; y has no effect
  m.prediction[0][1] = 0.0;
  m.most_moved[0] = 3.0;
  m.missing_limit[0] = 0.5;
  for (const bool gated : {true, false}) {
    Monitor<Model> monitor(m);
    Fake observer;
    const auto fly = [&](double y, double moves) {
      double kept = y;
      if (gated) kept = monitor.usable_outputs(y, observer);
      if (!std::isnan(kept)) observer.y = kept;
      observer.z = moves;
      (void)monitor.watch(observer, {{0.0}});
      return std::isnan(kept);
    };
    double y = 0.0;
    for (int k = 0; k < 50; ++k) EXPECT_FALSE(fly(y += 2.0, 1.0)) << k;  // one deviation per sample, as predicted
    for (int k = 0; k < 20; ++k) (void)fly(y, 1.0);
    EXPECT_EQ(fly(y, 1.0), gated) << "the gate rejects it";
    EXPECT_EQ(monitor.alarm(), Alarm::kMissing);
    for (int k = 0; k < 200; ++k) EXPECT_FALSE(fly(y += 2.0, 1.0)) << "it moves again";
    EXPECT_EQ(monitor.alarm(), Alarm::kNone);
    for (int k = 0; k < 200; ++k) EXPECT_FALSE(fly(y, 0.0)) << "control: at rest, it may repeat for any time";
    EXPECT_EQ(monitor.alarm(), Alarm::kNone);
  }
}

TEST(Monitor, InnovationIsScaledByTheLastDistanceOfTheLatentState) {
  Model m = quiet_model();
  m.motion[0] = 0.5;
  Monitor<Model> monitor(m);
  Fake observer;
  observer.z = -3.0;  // three deviations from the mean: innovations are 2.5 times as large
  (void)seen(monitor, observer, 0.0);
  observer.z = 0.0;
  (void)seen(monitor, observer, 4.0);
  EXPECT_DOUBLE_EQ(monitor.save().outputs[0].last, 2.0 / 2.5);
  observer.y = 0.0;
  (void)seen(monitor, observer, 4.0);
  EXPECT_DOUBLE_EQ(monitor.save().outputs[0].last, 2.0) << "control: at the mean, the innovation is not scaled";
}

TEST(Monitor, DisagreementIsTheSmoothedDistanceOfTheEstimateFromItsLinearFit) {
  Model m = quiet_model();
  m.row[0][0] = 2.0;  // x_hat / deviation = 2 z - y + 1
  m.row[0][1] = -1.0;
  m.row_offset[0] = 1.0;
  m.per_row_deviation[0] = 4.0;
  m.disagreement_limit[0] = 2.0;
  Monitor<Model> monitor(m);
  Fake observer;
  observer.z = 0.5;
  observer.y = 1.5;
  for (int k = 0; k < 50; ++k) ASSERT_EQ(monitor.watch(observer, {{(2.0 * 0.5 - 1.5 + 1.0) / 4.0}}), Alarm::kNone);
  // 3 (1 - exp(-n / 50)) > 2 from n = 54.9 on: window of 50 samples.
  int k = 0;
  while (monitor.watch(observer, {{(0.5 + 3.0) / 4.0}}) == Alarm::kNone && k < 200) ++k;
  EXPECT_EQ(k, 54);
  EXPECT_EQ(monitor.alarm(), Alarm::kDisagreement);
}

TEST(Monitor, WidensIntervalsByTheDisagreementAndMakesThemUnknownDuringAnAlarm) {
  Model m = quiet_model();
  m.per_row_deviation[0] = 1.0;  // the row is 0, so the disagreement is the smoothed |x_hat|
  m.disagreement_limit[0] = 7.0;
  Monitor<Model> monitor(m);
  Fake observer;
  const EstimateWithError<double, 1> plain{{{0.0}}, {{0.5}}, {{1.25}}};
  const auto after = [&](double x_hat, int samples) {
    for (int k = 0; k < samples; ++k) (void)monitor.watch(observer, {{x_hat}});
    return monitor.widened(plain);
  };
  EXPECT_EQ(after(1.9, 1000).sigma[0], 0.5) << "a disagreement below 2 is ordinary";
  const auto wider =
      after(6.0, 2000);  // 40 windows: the average is 6 except for rounding, three times the ordinary value
  EXPECT_NEAR(wider.sigma[0], 1.5, 1e-12);
  EXPECT_NEAR(wider.bound_95[0], 3.75, 1e-12);
  EXPECT_EQ(wider.x_hat[0], 0.0);
  const auto unknown = after(8.0, 2000);
  ASSERT_EQ(monitor.alarm(), Alarm::kDisagreement);
  EXPECT_EQ(unknown.sigma[0], static_cast<double>(kUnknownSigma));
  EXPECT_EQ(unknown.bound_95[0], 2.5 * static_cast<double>(kUnknownSigma));
  const double most = static_cast<double>(kUnknownSigma);
  const EstimateWithError<double, 1> outside{{{0.0}}, {{most}}, {{2.5 * most}}};
  monitor.reset();
  (void)after(6.0, 2000);
  ASSERT_EQ(monitor.alarm(), Alarm::kNone);
  EXPECT_EQ(monitor.widened(outside).sigma[0], most) << "an unknown error stays unknown, and finite in float";
}

TEST(Monitor, IsSilentUntilArmedAndAfterAReset) {
  Model m = quiet_model();
  m.variance_limit[0][0] = 0.5;  // white noise with one deviation exceeds it
  m.armed_after = 30;
  Monitor<Model> monitor(m);
  for (int run = 0; run < 2; ++run) {
    Fake observer;
    for (int k = 0; k < 30; ++k) ASSERT_EQ(seen(monitor, observer, k % 2 == 0 ? 2.0 : -2.0), Alarm::kNone) << k;
    EXPECT_GT(monitor.level(), 1.0);
    EXPECT_EQ(seen(monitor, observer, 2.0), Alarm::kInnovationVariance);
    monitor.reset();
    EXPECT_EQ(monitor.alarm(), Alarm::kNone);
    EXPECT_EQ(monitor.level(), 0.0);
  }
}

TEST(Monitor, IsNotArmedAfterAResetOfItsObserver) {
  Model m = quiet_model();
  m.variance_limit[0][0] = 0.5;
  m.armed_after = 30;
  Monitor<Model> monitor(m);
  Fake observer;
  const auto arm = [&] {
    for (int k = 0; k < 31; ++k) {
      EXPECT_FALSE(monitor.armed()) << k;
      (void)seen(monitor, observer, k % 2 == 0 ? 2.0 : -2.0);
    }
    EXPECT_TRUE(monitor.armed());
    EXPECT_EQ(monitor.alarm(), Alarm::kInnovationVariance);
  };
  arm();
  observer.started = 0;
  (void)monitor.usable_outputs(0.0, observer);  // before the step that starts the observer
  EXPECT_FALSE(monitor.armed());
  EXPECT_EQ(monitor.alarm(), Alarm::kNone);
  observer.started = 1;
  arm();
  observer.started = 0;
  EXPECT_EQ(monitor.watch(observer, {{0.0}}), Alarm::kNone) << "after a step that could not start the observer";
  EXPECT_FALSE(monitor.armed());
  observer.started = 1;
  arm();
  observer.started = 0;
  observer.last = StepStatus::kReset;
  EXPECT_EQ(monitor.watch(observer, {{0.0}}), Alarm::kReset) << "a bit flip reset the observer";
  EXPECT_FALSE(monitor.armed());
}

}  // namespace
}  // namespace nlo::monitor_tests
