// SPDX-License-Identifier: MIT
// The statistics of nlo/monitor.h against closed forms, on innovations that a test chooses: with a prediction of
// nothing and y = 0 before, the innovation is y itself over its deviation.
#include "nlo/monitor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>

namespace nlo {
namespace {

constexpr double kNone = 1e9;  // a limit that nothing passes

/// An observer that holds what it cannot use, and knows nothing else.
struct Fake {
  static constexpr int kNx = 1, kNz = 1, kNr = 1;
  struct Outputs {
    double wrap[1] = {0.0};
  };
  struct Model {
    Outputs outputs = {};
  };
  struct State {
    int started = 1;
    double y[1] = {0.0};
    StepStatus status = StepStatus::kOk;
  };
  Model own{};
  double y = 0.0, z = 0.0;
  int started = 1;
  StepStatus status = StepStatus::kOk;

  constexpr const Model& model() const { return own; }
  constexpr State save() const { return {started, {y}, status}; }
  constexpr Vector<double, 1> relative_latent() const { return {{z}}; }
};

using Model = MonitorModel<double, 1, 1, 1, 1, 2>;

/// Deviation 2; the change from the last y is expected to lead back to 0: e = y / 2. Windows of 10 and 50 samples.
Model quiet_model() {
  Model m{};
  m.prediction[0][1] = -0.5;
  m.per_deviation[0] = 0.5;
  m.least_variance[0] = 0.01;
  m.per_latent_deviation[0] = 1.0;
  for (int w = 0; w < 2; ++w) {
    m.gain[w] = -std::expm1(-1.0 / (w == 0 ? 10.0 : 50.0));
    m.mean_limit[0][w] = m.variance_limit[0][w] = m.correlation_limit[0][w] = m.latent_limit[w] = kNone;
  }
  m.missing_limit[0] = kNone;
  m.gate_squared = 16.0;
  m.armed_after = 0;
  return m;
}

Alarm seen(Monitor<Model>& monitor, Fake& observer, double y) {
  const double kept = monitor.screened(y, observer);
  if (!std::isnan(kept)) observer.y = kept;
  return monitor.watch(observer, Vector<double, 1>{{0.0}});
}

/// Samples until the first alarm of this kind; -1: none, or another one came first.
int first_alarm(const Model& model, Alarm wanted, double (*y)(int), int samples = 1000) {
  Monitor<Model> monitor(model);
  Fake observer;
  for (int k = 0; k < samples; ++k) {
    const Alarm alarm = seen(monitor, observer, y(k));
    if (alarm != Alarm::kNone) return alarm == wanted ? k : -1;
  }
  return -1;
}

TEST(Monitor, ConstantInnovationReachesItsVarianceAsAnExponential) {
  // v after n innovations of e: 1 + (1 - exp(-n / window)) (e^2 - 1), from v = 1. With e = 2 (y = 4) and window 10 the
  // limit 2.5 is passed when 1 - exp(-n / 10) > .5: at n = 7. The first sample gives no innovation.
  Model m = quiet_model();
  m.variance_limit[0][0] = 2.5;
  EXPECT_EQ(first_alarm(m, Alarm::kInnovationVariance, [](int) { return 4.0; }), 7);
}

TEST(Monitor, PowerOfTheSmoothedInnovationSeesWhatIsOffEitherWay) {
  // e = sin(k / 20) has mean zero and variance .5; white noise of that size does not pass through the window of 10.
  Model m = quiet_model();
  m.mean_limit[0][0] = 0.5;
  EXPECT_GT(first_alarm(m, Alarm::kInnovationMean, [](int k) { return 2.0 * std::sin(k / 20.0); }), 0);
  EXPECT_EQ(first_alarm(m, Alarm::kInnovationMean, [](int k) { return k % 2 == 0 ? 2.0 : -2.0; }), -1);
}

TEST(Monitor, CorrelationSeesInnovationsThatAlternate) {
  Model m = quiet_model();
  m.correlation_limit[0][1] = 0.5;
  // e = -1, 1, -1, ...: e e_last = -1, so |r| = 1 - exp(-n / 50) is above .5 from n = 35 on,
  // one sample and one more late.
  EXPECT_EQ(first_alarm(m, Alarm::kInnovationCorrelation, [](int k) { return k % 2 == 0 ? 2.0 : -2.0; }), 36);
}

TEST(Monitor, PredictionIsItsRowOfLatentStateReadingsAndEstimate) {
  Model m = quiet_model();
  m.offset[0] = 0.125;
  m.prediction[0][0] = 0.5;
  m.prediction[0][1] = -0.25;
  m.prediction[0][2] = 2.0;
  Monitor<Model> monitor(m);
  Fake observer;
  observer.z = 3.0;
  observer.y = monitor.screened(-1.0, observer);
  (void)monitor.watch(observer, Vector<double, 1>{{0.75}});
  EXPECT_EQ(monitor.save().outputs[0].predicted, 0.125 + 0.5 * 3.0 - 0.25 * -1.0 + 2.0 * 0.75);
}

/// Two outputs, the first an angle; three latent coordinates, three readings, two states, three windows.
struct Wide {
  using Model = MonitorModel<double, 2, 2, 3, 3, 3>;
  static constexpr int kNx = 2, kNz = 3, kNr = 3;
  struct Outputs {
    double wrap[3] = {0.75, 0.0, 0.0};
  };
  struct Own {
    Outputs outputs = {};
  };
  struct State {
    int started = 1;
    double y[3];
    StepStatus status = StepStatus::kOk;
  };
  Own own{};
  double y[3] = {}, z[3] = {};

  const Own& model() const { return own; }
  State save() const { return {1, {y[0], y[1], y[2]}, StepStatus::kOk}; }
  Vector<double, 3> relative_latent() const { return {{z[0], z[1], z[2]}}; }
};

/// The recursions of nlo/monitor.h as its first lines write them.
struct Recursions {
  static constexpr double kMost = kLargestInnovation;
  const Wide::Model& m;
  double mean[2][3]{}, power[2][3]{}, variance[2][3]{{1, 1, 1}, {1, 1, 1}}, correlation[2][3]{};
  double distance[3] = {1, 1, 1}, share[2]{}, last[2]{}, predicted[2]{}, y[2]{};
  int rejected[2]{}, samples = 0;
  bool missing[2]{};
  double level = 0.0;
  Alarm alarm = Alarm::kNone;

  double innovation(int j, double reading) const {
    const double change = j == 0 ? std::remainder(reading - y[j], 0.75) : reading - y[j];
    return change * m.per_deviation[j] - predicted[j];
  }
  void screen(const Vector<double, 2>& given) {
    for (int j = 0; j < 2; ++j) {
      missing[j] = std::isnan(given[j]);
      if (missing[j] || samples == 0) continue;
      const double e = innovation(j, given[j]);
      missing[j] = e * e > m.gate_squared * std::max(1.0, variance[j][0]) && rejected[j] < kMostRejected;
      rejected[j] = missing[j] ? rejected[j] + 1 : 0;
    }
  }
  void ask(double value, double limit, Alarm kind) {
    if (value / limit <= level) return;
    level = value / limit;
    alarm = kind;
  }
  void watch(const Wide& observer, const Vector<double, 2>& x_hat) {
    double square = 0.0;
    for (int r = 0; r < 3; ++r) square += std::pow((observer.z[r] - m.latent_mean[r]) * m.per_latent_deviation[r], 2);
    for (int w = 0; w < 3; ++w) distance[w] += m.gain[w] * (std::min(square / 3.0, kMost * kMost) - distance[w]);
    for (int j = 0; j < 2; ++j) {
      if (samples > 0 && !missing[j]) {
        const double e = std::clamp(innovation(j, observer.y[j]), -kMost, kMost);
        for (int w = 0; w < 3; ++w) {
          mean[j][w] += m.gain[w] * (e - mean[j][w]);
          power[j][w] += m.gain[2] * (mean[j][w] * mean[j][w] - power[j][w]);
          variance[j][w] += m.gain[w] * (e * e - variance[j][w]);
          correlation[j][w] += m.gain[w] * (e * last[j] - correlation[j][w]);
        }
        last[j] = e;
      }
      share[j] += m.gain[0] * ((missing[j] ? 1.0 : 0.0) - share[j]);
      predicted[j] = m.offset[j];
      for (int i = 0; i < 3; ++i)
        predicted[j] += m.prediction[j][i] * observer.z[i] + m.prediction[j][3 + i] * observer.y[i];
      for (int i = 0; i < 2; ++i) predicted[j] += m.prediction[j][6 + i] * x_hat[i];
      y[j] = observer.y[j];
    }
    samples = std::min(samples + 1, m.armed_after + 1);
    level = 0.0;
    for (int w = 0; w < 3; ++w) {
      ask(distance[w], m.latent_limit[w], Alarm::kLatentDistance);
      for (int j = 0; j < 2; ++j) {
        const double noise = std::max(variance[j][w], m.least_variance[j]);
        ask(power[j][w] / noise, m.mean_limit[j][w], Alarm::kInnovationMean);
        ask(variance[j][w], m.variance_limit[j][w], Alarm::kInnovationVariance);
        ask(std::abs(correlation[j][w]), m.correlation_limit[j][w], Alarm::kInnovationCorrelation);
        ask(share[j], m.missing_limit[j], Alarm::kMissing);
      }
    }
    if (!(level > 1.0 && samples > m.armed_after)) alarm = Alarm::kNone;
  }
};

TEST(Monitor, EveryStatisticIsItsRecursionInEachOutputAndWindow) {
  std::mt19937 engine(5);
  const auto within = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  };
  Wide::Model m{};
  for (int w = 0; w < 3; ++w) m.gain[w] = std::pow(0.3, w + 1);
  for (int j = 0; j < 2; ++j) {
    for (double& weight : m.prediction[j]) weight = within(-0.2, 0.2);
    m.offset[j] = within(-0.2, 0.2);
    m.per_deviation[j] = 20.0 + 5.0 * j;  // e = 7.5 is half a turn
    m.least_variance[j] = 0.5 + 0.2 * j;
    m.missing_limit[j] = 0.7 + 0.1 * j;
    for (int w = 0; w < 3; ++w) {
      m.mean_limit[j][w] = within(0.5, 0.7);
      m.variance_limit[j][w] = within(5.0, 7.0);
      m.correlation_limit[j][w] = within(0.9, 1.2);
      m.latent_limit[w] = within(3.0, 4.0);
    }
  }
  m.prediction[1][4] = -5.0;  // back to 0: what is predicted stays within half a turn
  for (int r = 0; r < 3; ++r) {
    m.latent_mean[r] = within(-1.0, 1.0);
    m.per_latent_deviation[r] = within(1.0, 3.0);
  }
  m.gate_squared = 16.0;
  m.armed_after = 20;

  enum { kCalm, kBias, kNoise, kAlternating, kFarAway, kMissing, kJump, kKinds };
  Monitor<Wide::Model> monitor(m);
  Recursions want{m};
  Wide observer;
  int alarms[7] = {};
  for (int k = 0; k < 300 * kKinds; ++k) {
    const int j_wrong = k / (150 * kKinds), kind = k / 150 % kKinds;  // first of one output, then of the other
    Vector<double, 2> y{}, x_hat{{within(-1.0, 1.0), within(-1.0, 1.0)}};
    for (int j = 0; j < 2; ++j) {
      double e = within(-1.0, 1.0);
      if (j == j_wrong && kind == kBias) e += 1.5;
      if (j == j_wrong && kind == kNoise) e *= 5.5;
      if (j == j_wrong && kind == kAlternating) e = k % 2 == 0 ? 1.6 : -1.6;
      if (j == j_wrong && kind == kJump && k % 150 < 40) e = 6.5;
      y[j] = want.y[j] + (want.predicted[j] + e) / m.per_deviation[j];
      if (j == j_wrong && kind == kMissing && k % 20 != 0) y[j] = std::numeric_limits<double>::quiet_NaN();
    }
    const auto kept = monitor.screened(y, observer);
    want.screen(y);
    for (int j = 0; j < 2; ++j) {
      ASSERT_EQ(std::isnan(kept[j]), want.missing[j]) << k;
      if (!std::isnan(kept[j])) observer.y[j] = j == 0 ? std::remainder(kept[j], 0.75) : kept[j];
    }
    observer.y[2] = within(0.0, 1.0);
    for (int r = 0; r < 3; ++r)
      observer.z[r] = m.latent_mean[r] + within(-1.0, 1.0) * (kind == kFarAway ? 5.0 : 1.0) / m.per_latent_deviation[r];
    ASSERT_EQ(monitor.watch(observer, x_hat), (want.watch(observer, x_hat), want.alarm)) << k;
    ++alarms[static_cast<int>(want.alarm)];

    constexpr double kRounding = 1e-10;
    const auto got = monitor.save();
    ASSERT_NEAR(got.level, want.level, kRounding) << k;
    ASSERT_EQ(got.samples, want.samples);
    for (int w = 0; w < 3; ++w) ASSERT_NEAR(got.distance[w], want.distance[w], kRounding) << k;
    for (int j = 0; j < 2; ++j) {
      const auto& own = got.outputs[j];
      ASSERT_NEAR(own.predicted, want.predicted[j], kRounding) << k;
      ASSERT_NEAR(own.last, want.last[j], kRounding) << k;
      ASSERT_NEAR(own.missing_share, want.share[j], kRounding) << k;
      ASSERT_EQ(own.rejected, want.rejected[j]) << k;
      for (int w = 0; w < 3; ++w) {
        ASSERT_NEAR(own.windows[w].mean, want.mean[j][w], kRounding) << k;
        ASSERT_NEAR(own.windows[w].power, want.power[j][w], kRounding) << k;
        ASSERT_NEAR(own.windows[w].variance, want.variance[j][w], kRounding) << k;
        ASSERT_NEAR(own.windows[w].correlation, want.correlation[j][w], kRounding) << k;
      }
    }
  }
  for (int kind = 0; kind <= static_cast<int>(Alarm::kMissing); ++kind)
    EXPECT_GT(alarms[kind], 0) << "control: " << kind;
}

TEST(Monitor, AtItsLimitThereIsNoAlarmAndAtTheGateNoOutlier) {
  Model m = quiet_model();
  m.latent_limit[0] = 1.0;
  Monitor<Model> monitor(m);
  Fake observer;
  observer.z = 1.0;  // one deviation: d stays at 1
  for (int k = 0; k < 5; ++k) EXPECT_EQ(seen(monitor, observer, 0.0), Alarm::kNone);
  EXPECT_EQ(monitor.level(), 1.0);
  EXPECT_EQ(monitor.screened(8.0, observer), 8.0) << "four deviations, and less noise than in training";
  EXPECT_TRUE(std::isnan(monitor.screened(8.001, observer)));
  auto state = monitor.save();
  state.outputs[0].windows[0].variance = 1.5;  // of the shortest window, and not of another
  ASSERT_TRUE(monitor.restore(state));
  EXPECT_EQ(monitor.screened(9.79, observer), 9.79) << "4.895 of 4 sqrt(1.5) = 4.899 deviations";
  EXPECT_TRUE(std::isnan(monitor.screened(9.81, observer)));
  (void)monitor.watch(observer, {{0.0}});
  EXPECT_EQ(monitor.save().outputs[0].missing, 0) << "of one sample";
}

TEST(Monitor, InnovationOfAnAngleGoesTheShortWayRound) {
  Model m = quiet_model();
  m.prediction[0][1] = 0.0;
  Fake observer;
  observer.own.outputs.wrap[0] = 6.25;
  const auto first_innovation = [&] {
    Monitor<Model> monitor(m);
    observer.y = 0.0;
    (void)seen(monitor, observer, 3.0);
    (void)seen(monitor, observer, -3.0);  // 0.25 further on, or 6 back
    return monitor.save().outputs[0].last;
  };
  EXPECT_EQ(first_innovation(), 0.125) << "deviation 2";
  observer.own.outputs.wrap[0] = 0.0;
  EXPECT_EQ(first_innovation(), -3.0) << "control";
}

TEST(Monitor, PlaceOfTheLatentStateIsWeighed) {
  Model m = quiet_model();
  m.latent_limit[0] = 2.0;
  Monitor<Model> monitor(m);
  Fake observer;
  observer.z = 1.0;  // one deviation: d stays at 1
  for (int k = 0; k < 100; ++k) ASSERT_EQ(seen(monitor, observer, 0.0), Alarm::kNone);
  observer.z = 2.0;  // d goes to 4
  int k = 0;
  while (seen(monitor, observer, 0.0) == Alarm::kNone && k < 100) ++k;
  EXPECT_EQ(k, 4);  // 1 + 3 (1 - exp(-n / 10)) > 2 from n = 4.05 on: the fifth
  EXPECT_EQ(monitor.alarm(), Alarm::kLatentDistance);
}

TEST(Monitor, MissingMeasurementsAreCountedAndDoNotCountAsInnovations) {
  Model m = quiet_model();
  m.missing_limit[0] = 0.5;
  m.variance_limit[0][0] = 1.5;
  const auto missing = [](int k) { return k < 20 ? 0.0 : std::numeric_limits<double>::quiet_NaN(); };
  EXPECT_EQ(first_alarm(m, Alarm::kMissing, missing), 20 + 6);  // 1 - exp(-n / 10) > .5 at the seventh
}

TEST(Monitor, OutliersAreKeptFromTheObserverAndSoOnesThatStayAreBelieved) {
  const Model m = quiet_model();
  Monitor<Model> monitor(m);
  Fake observer;
  std::mt19937 engine(1);
  std::normal_distribution<double> noise(0.0, 2.0);  // one deviation
  for (int k = 0; k < 200; ++k) (void)seen(monitor, observer, noise(engine));
  EXPECT_FALSE(std::isnan(monitor.screened(7.0, observer)));  // 3.5 deviations
  EXPECT_TRUE(std::isnan(monitor.screened(40.0, observer)));  // 20
  EXPECT_TRUE(std::isnan(monitor.screened(-40.0, observer)));
  (void)seen(monitor, observer, 0.0);
  int rejected = 0;
  while (std::isnan(monitor.screened(40.0, observer)) && rejected < 100) ++rejected;
  EXPECT_EQ(rejected, kMostRejected);
}

TEST(Monitor, GateWidensWithTheNoise) {
  // Of a sensor four times as noisy as in training one in 3 is beyond 4 deviations; behind a gate that stays, the
  // observer would be blind for a third of the time.
  const Model m = quiet_model();
  Monitor<Model> monitor(m);
  Fake observer;
  std::mt19937 engine(2);
  std::normal_distribution<double> noise(0.0, 8.0);
  int rejected = 0;
  for (int k = 0; k < 5000; ++k) {
    const double y = noise(engine);
    if (k > 100 && std::isnan(monitor.screened(y, observer))) ++rejected;
    (void)seen(monitor, observer, y);
  }
  EXPECT_LT(rejected, 250);  // 5 %
}

TEST(Monitor, IsSilentUntilArmedAndAfterAReset) {
  Model m = quiet_model();
  m.variance_limit[0][0] = 0.5;  // white noise of one deviation is above it
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

TEST(Monitor, OfAnObserverThatIsResetIsNotArmedAndSaysSo) {
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
  (void)monitor.screened(0.0, observer);  // before the step that starts it
  EXPECT_FALSE(monitor.armed());
  EXPECT_EQ(monitor.alarm(), Alarm::kNone);
  observer.started = 1;
  arm();
  observer.started = 0;
  EXPECT_EQ(monitor.watch(observer, {{0.0}}), Alarm::kNone) << "after a step that could not start it";
  EXPECT_FALSE(monitor.armed());
  observer.started = 1;
  arm();
  observer.started = 0;
  observer.status = StepStatus::kReset;
  EXPECT_EQ(monitor.watch(observer, {{0.0}}), Alarm::kReset) << "a flipped bit has reset it";
  EXPECT_FALSE(monitor.armed());
}

TEST(Monitor, ContinuesFromASavedState) {
  const Model m = quiet_model();
  Monitor<Model> monitor(m);
  Fake observer;
  std::mt19937 engine(4);
  std::normal_distribution<double> noise(0.0, 2.0);
  for (int k = 0; k < 50; ++k) (void)seen(monitor, observer, noise(engine));
  Monitor<Model> other(m);
  ASSERT_TRUE(other.restore(monitor.save()));
  EXPECT_EQ(other.armed(), monitor.armed());
  Fake beside = observer;
  for (int k = 0; k < 50; ++k) {
    const double y = noise(engine);
    ASSERT_EQ(seen(monitor, observer, y), seen(other, beside, y));
    ASSERT_EQ(monitor.level(), other.level());
  }
}

TEST(Monitor, RefusesAStateThatWatchingCannotReach) {
  const Model m = quiet_model();
  Monitor<Model> monitor(m);
  Fake observer;
  for (int k = 0; k < 5; ++k) (void)seen(monitor, observer, 1.0);
  using State = Monitor<Model>::State;
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  using Spoil = void (*)(State&);
  const Spoil spoils[] = {[](State& s) { s.samples = -2147483647; },
                          [](State& s) { s.samples = 2; },
                          [](State& s) { s.level = kNaN; },
                          [](State& s) { s.alarm = static_cast<Alarm>(200); },
                          [](State& s) { s.distance[1] = 26.0; },
                          [](State& s) { s.outputs[0].last = 6.0; },
                          [](State& s) { s.outputs[0].y = kNaN; },
                          [](State& s) { s.outputs[0].predicted = 2e6; },
                          [](State& s) { s.outputs[0].missing = 2; },
                          [](State& s) { s.outputs[0].missing_share = -2.0; },
                          [](State& s) { s.outputs[0].rejected = 21; },
                          [](State& s) { s.outputs[0].windows[0].mean = kNaN; },
                          [](State& s) { s.outputs[0].windows[1].power = 1e30; },
                          [](State& s) { s.outputs[0].windows[0].variance = -30.0; },
                          [](State& s) { s.outputs[0].windows[1].correlation = kNaN; }};
  for (const Spoil spoil : spoils) {
    State state = monitor.save();
    ASSERT_TRUE(monitor.restore(state));
    spoil(state);
    EXPECT_FALSE(monitor.restore(state)) << &spoil - spoils;
  }
}

TEST(Monitor, TakesAStateAtTheEndsOfWhatWatchingReaches) {
  const Model m = quiet_model();
  Monitor<Model> monitor(m);
  Fake observer;
  for (int k = 0; k < 5; ++k) (void)seen(monitor, observer, 1.0);
  auto state = monitor.save();
  EXPECT_EQ(state.samples, m.armed_after + 1);
  state.alarm = Alarm::kReset;
  state.distance[0] = 25.0;
  auto& own = state.outputs[0];
  own.rejected = kMostRejected;
  own.missing = 1;  // between screened() and watch()
  own.missing_share = 1.0;
  own.last = -5.0;
  own.predicted = 1e6;
  own.windows[1] = {-5.0, 25.0, 25.0, -25.0};
  EXPECT_TRUE(monitor.restore(state));
  monitor.reset();
  EXPECT_TRUE(monitor.restore(monitor.save()));
}

TEST(Monitor, StatisticsThatAreTogetherMoreThanSamplesLeadToAreAReset) {
  // 1.01 * 25 is the most of power, variance and correlation of 2 outputs in 3 windows, of 3 distances and of 2 shares.
  // Fresh, the variances and the distances are 1; with gains of nothing they stay.
  Wide::Model m{};
  for (auto* limits : {m.mean_limit, m.variance_limit, m.correlation_limit}) std::fill_n(limits[0], 6, kNone);
  std::fill_n(m.latent_limit, 3, kNone);
  std::fill_n(m.missing_limit, 2, kNone);
  std::fill_n(m.least_variance, 2, 1.0);
  using Watch = Monitor<Wide::Model>;
  static_assert(sizeof(Watch) == sizeof(void*) + sizeof(Watch::State), "the pointer to the model, and the state");
  const auto after = [&](auto spoil) {
    Watch monitor(m);
    const Wide observer;
    (void)monitor.watch(observer, {});
    auto state = monitor.save();
    spoil(state);
    std::memcpy(reinterpret_cast<unsigned char*>(&monitor) + sizeof(void*), &state, sizeof(state));
    return monitor.watch(observer, {});
  };
  constexpr double kRoom = 1.01 * 25.0 * (2 * 3 * 3 + 3 + 2) - 9.0, kLittle = 1e-3;
  using Place = double& (*)(Watch::State&);
  const Place places[] = {[](Watch::State& s) -> double& { return s.outputs[0].windows[0].power; },
                          [](Watch::State& s) -> double& { return s.outputs[1].windows[1].correlation; },
                          [](Watch::State& s) -> double& { return s.outputs[0].missing_share; },
                          [](Watch::State& s) -> double& { return s.outputs[1].windows[2].variance; },
                          [](Watch::State& s) -> double& { return s.distance[2]; }};
  for (const Place place : places) {
    EXPECT_EQ(after([&](Watch::State& s) { place(s) += kRoom - kLittle; }), Alarm::kNone) << &place - places;
    EXPECT_EQ(after([&](Watch::State& s) { place(s) += kRoom + kLittle; }), Alarm::kReset) << &place - places;
  }
  EXPECT_EQ(after([](Watch::State& s) { s.samples = 2; }), Alarm::kReset) << "armed after 0: 1 is the most";
  EXPECT_EQ(after([](Watch::State& s) { s.samples = -2; }), Alarm::kReset);
  EXPECT_EQ(after([](Watch::State&) {}), Alarm::kNone) << "control";
}

TEST(Monitor, StaysFiniteWhateverArrives) {
  Model m = quiet_model();
  m.missing_limit[0] = 0.5;
  Monitor<Model> monitor(m);
  Fake observer;
  std::mt19937_64 engine(3);
  const auto bits = [&] { return std::bit_cast<double>(static_cast<std::uint64_t>(engine())); };
  for (int k = 0; k < 100000; ++k) {
    const double kept = monitor.screened(bits(), observer);
    if (!std::isnan(kept)) observer.y = kept;
    observer.z = bits();
    (void)monitor.watch(observer, Vector<double, 1>{{bits()}});
    ASSERT_TRUE(is_finite(monitor.level())) << k;
    ASSERT_NE(monitor.alarm(), Alarm::kReset) << "what is measured leads nowhere outside";
    ASSERT_TRUE(k % 100 != 0 || monitor.restore(monitor.save())) << k;
  }
  // And comes back: what was seen is forgotten.
  observer.y = observer.z = 0.0;
  Alarm last = Alarm::kMissing;
  for (int k = 0; k < 2000; ++k) last = seen(monitor, observer, 0.0);
  EXPECT_EQ(last, Alarm::kNone);
}

constexpr bool watches_at_compile_time() {
  Model m{};
  m.latent_limit[0] = m.latent_limit[1] = m.missing_limit[0] = 1e9;
  m.mean_limit[0][0] = m.mean_limit[0][1] = m.variance_limit[0][0] = m.variance_limit[0][1] = 1e9;
  m.correlation_limit[0][0] = m.correlation_limit[0][1] = 1e9;
  m.least_variance[0] = 1.0;
  m.gate_squared = 1.0;
  Monitor<Model> monitor(m);
  Fake observer;
  return monitor.screened(0.5, observer) == 0.5 && monitor.watch(observer, {{0.0}}) == Alarm::kNone;
}
static_assert(watches_at_compile_time());

}  // namespace
}  // namespace nlo
