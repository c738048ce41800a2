// SPDX-License-Identifier: MIT
// The statistics of nlo/monitor.h against closed forms, on innovations that a test chooses: with a prediction of nothing
// and y = 0 before, the innovation is y itself over its deviation.
#include "nlo/monitor.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
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
  // e = -1, 1, -1, ...: e e_last = -1, so |r| = 1 - exp(-n / 50) is above .5 from n = 35 on, one sample and one more late.
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
  // Of a sensor four times as noisy as in training one in 3 is beyond 4 deviations; behind a gate that stays, the observer
  // would be blind for a third of the time.
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
                          [](State& s) { s.samples = 3; },
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
