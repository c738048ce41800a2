// SPDX-License-Identifier: MIT
// The state of a monitor: saved and restored, refused if watching cannot reach it, finite for any input.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>

#include "nlo/monitor.h"
#include "tests/runtime/watched_fakes.h"

namespace nlo::monitor_tests {
namespace {

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
  for (int k = 0; k <= kArmedAfter; ++k) (void)seen(monitor, observer, 1.0);
  using State = Monitor<Model>::State;
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  using Corruption = void (*)(State&);
  const Corruption corruptions[] = {[](State& s) { s.samples = -2147483647; },
                                    [](State& s) { s.samples = kArmedAfter + 2; },
                                    [](State& s) { s.level = kNaN; },
                                    [](State& s) { s.alarm = static_cast<Alarm>(200); },
                                    [](State& s) { s.distance[1] = 26.0; },
                                    [](State& s) { s.disagreement[0] = kNaN; },
                                    [](State& s) { s.place = 6.0; },
                                    [](State& s) { s.gated = 2; },
                                    [](State& s) { s.outputs[0].moved = kNaN; },
                                    [](State& s) { s.outputs[0].last = 6.0; },
                                    [](State& s) { s.outputs[0].y = kNaN; },
                                    [](State& s) { s.outputs[0].predicted = 2e6; },
                                    [](State& s) { s.outputs[0].missing = 2; },
                                    [](State& s) { s.outputs[0].missing_share = -2.0; },
                                    [](State& s) { s.outputs[0].rejected = 21; },
                                    [](State& s) { s.outputs[0].raw = kNaN; },
                                    [](State& s) { s.outputs[0].windows[0].mean = kNaN; },
                                    [](State& s) { s.outputs[0].windows[1].power = 1e30; },
                                    [](State& s) { s.outputs[0].windows[0].variance = -30.0; },
                                    [](State& s) { s.outputs[0].windows[1].correlation = kNaN; }};
  for (const Corruption corrupt : corruptions) {
    State state = monitor.save();
    ASSERT_TRUE(monitor.restore(state));
    corrupt(state);
    EXPECT_FALSE(monitor.restore(state)) << &corrupt - corruptions;
  }
}

TEST(Monitor, RestoresAStateWithTheLargestPossibleValues) {
  const Model m = quiet_model();
  Monitor<Model> monitor(m);
  Fake observer;
  for (int k = 0; k <= kArmedAfter; ++k) (void)seen(monitor, observer, 1.0);
  auto state = monitor.save();
  EXPECT_EQ(state.samples, m.armed_after + 1);
  state.alarm = Alarm::kReset;
  state.distance[0] = 25.0;
  auto& own = state.outputs[0];
  own.rejected = kMostRejected;
  own.missing = 1;  // between usable_outputs() and watch()
  own.equal = 65535;
  own.missing_share = 1.0;
  own.last = -5.0;
  own.predicted = 1e6;
  own.windows[1] = {-5.0, 25.0, 25.0, -25.0};
  EXPECT_TRUE(monitor.restore(state));
  monitor.reset();
  EXPECT_TRUE(monitor.restore(monitor.save()));
}

TEST(Monitor, StatisticsWithAnImpossibleSumCauseAReset) {
  // 1.01 * 25 is the largest possible sum of power, variance and correlation of 2 outputs in 3 windows, of 3 distances,
  // 2 shares and 2 disagreements. In a new monitor the variances and distances are 1; with gains of zero they stay 1.
  Wide::Model m{};
  for (auto* limits : {m.mean_limit, m.variance_limit, m.correlation_limit}) std::fill_n(limits[0], 6, kNone);
  std::fill_n(m.latent_limit, 3, kNone);
  std::fill_n(m.missing_limit, 2, kNone);
  std::fill_n(m.least_variance, 2, 1.0);
  std::fill_n(m.per_row_deviation, 2, 1.0);
  std::fill_n(m.disagreement_limit, 2, kNone);
  using Watch = Monitor<Wide::Model>;
  static_assert(sizeof(Watch) == sizeof(void*) + sizeof(Watch::State), "the pointer to the model, and the state");
  const auto after = [&](auto corrupt) {
    Watch monitor(m);
    const Wide observer;
    (void)monitor.watch(observer, {});
    auto state = monitor.save();
    corrupt(state);
    std::memcpy(reinterpret_cast<unsigned char*>(&monitor) + sizeof(void*), &state, sizeof(state));
    return monitor.watch(observer, {});
  };
  constexpr double kRoom = 1.01 * 25.0 * (2 * 3 * 3 + 3 + 2 + 2) - 9.0, kLittle = 1e-3;
  using Place = double& (*)(Watch::State&);
  const Place places[] = {[](Watch::State& s) -> double& { return s.outputs[0].windows[0].power; },
                          [](Watch::State& s) -> double& { return s.outputs[1].windows[1].correlation; },
                          [](Watch::State& s) -> double& { return s.outputs[0].missing_share; },
                          [](Watch::State& s) -> double& { return s.outputs[1].windows[2].variance; },
                          [](Watch::State& s) -> double& { return s.disagreement[1]; },
                          [](Watch::State& s) -> double& { return s.distance[2]; }};
  for (const Place place : places) {
    EXPECT_EQ(after([&](Watch::State& s) { place(s) += kRoom - kLittle; }), Alarm::kNone) << &place - places;
    EXPECT_EQ(after([&](Watch::State& s) { place(s) += kRoom + kLittle; }), Alarm::kReset) << &place - places;
  }
  EXPECT_EQ(after([](Watch::State& s) { s.samples = 2; }), Alarm::kReset)
      << "armed after 0 samples: 1 is the largest count";
  EXPECT_EQ(after([](Watch::State& s) { s.samples = -2; }), Alarm::kReset);
  EXPECT_EQ(after([](Watch::State&) {}), Alarm::kNone) << "control";
}

TEST(Monitor, StaysFiniteForAnyInput) {
  Model m = quiet_model();
  m.missing_limit[0] = 0.5;
  Monitor<Model> monitor(m);
  Fake observer;
  std::mt19937_64 engine(3);
  const auto bits = [&] { return std::bit_cast<double>(static_cast<std::uint64_t>(engine())); };
  for (int k = 0; k < 100000; ++k) {
    const double kept = monitor.usable_outputs(bits(), observer);
    if (!std::isnan(kept)) observer.y = kept;
    observer.z = bits();
    (void)monitor.watch(observer, Vector<double, 1>{{bits()}});
    ASSERT_TRUE(is_finite(monitor.level())) << k;
    ASSERT_NE(monitor.alarm(), Alarm::kReset) << "no measurement leads to an unreachable state";
    ASSERT_TRUE(k % 100 != 0 || monitor.restore(monitor.save())) << k;
  }
  // The monitor recovers, because it forgets earlier measurements.
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
  return monitor.usable_outputs(0.5, observer) == 0.5 && monitor.watch(observer, {{0.0}}) == Alarm::kNone;
}
static_assert(watches_at_compile_time());

}  // namespace
}  // namespace nlo::monitor_tests
