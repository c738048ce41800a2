// SPDX-License-Identifier: MIT
// Bit flips in the memory of an observer or its monitor. After each flip, the pair either continues as if nothing had
// happened, or reports it. A flip is silent if the monitor or the estimate keeps differing from a twin without the
// flip, and no status and no alarm reported it. No flip may be silent. (Pointers to the models are not flipped.)
#include <nlo/driven_kkl_observer.h>
#include <nlo/general_observer.h>
#include <nlo/luenberger_observer.h>
#include <nlo/monitor.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <random>
#include <string>

#include "tests/runtime/structures.h"

namespace nlo {
namespace {

constexpr int kArmedAfter = 60;
constexpr int kPeriod = 400, kFault = 20;        // samples: period and duration of sensor faults
constexpr int kSettled = 40 * kPeriod;           // after this time the pair must equal its twin, even for z = 1e30
constexpr int kFlips = 20'000, kStructures = 8;  // equally many for each structure

/// y is periodic; in a fault it jumps between two values, which no prediction follows.
float measured(int k) {
  const int in_period = k % kPeriod;
  if (in_period >= kPeriod - kFault) return in_period % 2 == 0 ? 1.5F : -1.5F;
  return std::sin(0.05F * static_cast<float>(in_period));
}

/// Deviation .2, prediction zero: e is at most .25 for the wave, and the largest possible for a fault.
template <class Observer>
auto monitor_model() {
  using Model = MonitorModel<float, Observer::kNx, Observer::kNy, Observer::kNz, Observer::kNr, 2>;
  Model m{};
  for (int r = 0; r < Observer::kNz; ++r) m.per_latent_deviation[r] = 0.2F;
  for (int w = 0; w < 2; ++w) {
    m.gain[w] = w == 0 ? 0.2F : 0.05F;
    m.latent_limit[w] = 20.0F;
  }
  for (int j = 0; j < Observer::kNy; ++j) {
    m.per_deviation[j] = 5.0F;
    m.least_variance[j] = 0.5F;
    m.missing_limit[j] = 0.8F;
    for (int w = 0; w < 2; ++w) {
      m.mean_limit[j][w] = 4.0F;
      m.variance_limit[j][w] = 4.0F;
      m.correlation_limit[j][w] = 4.0F;
    }
  }
  m.gate_squared = 1e4F;
  m.armed_after = kArmedAfter;
  return m;
}

template <class Observer>
struct Pair {
  using Watch = Monitor<decltype(monitor_model<Observer>())>;
  Observer observer;
  Watch monitor;
  StepStatus status = StepStatus::kOk;

  void fly(int k) {
    const auto y = monitor.usable_outputs(typename Observer::Output{{measured(k)}}, observer);
    if constexpr (Observer::kDriven) {
      typename Observer::Input u{};
      for (float& entry : u) entry = 0.2F;
      status = observer.step(y, u);
    } else {
      status = observer.step(y);
    }
    (void)monitor.watch(observer, observer.estimate());
  }

  /// Number of bits after the pointer to the model.
  static constexpr std::size_t kObserverBits = 8 * (sizeof(Observer) - sizeof(void*));
  static constexpr std::size_t kMonitorBits = 8 * (sizeof(Watch) - sizeof(void*));
  void flip(std::size_t bit) {
    auto* bytes = reinterpret_cast<unsigned char*>(bit < kObserverBits ? static_cast<void*>(&observer)
                                                                       : static_cast<void*>(&monitor));
    if (bit >= kObserverBits) bit -= kObserverBits;
    unsigned char& byte = bytes[sizeof(void*) + bit / 8];
    byte = static_cast<unsigned char>(byte ^ (1U << (bit % 8)));
  }
};

template <class P>
bool together(const P& one, const P& other) {
  const auto z = one.observer.latent(), z_other = other.observer.latent();
  for (int r = 0; r < z.size(); ++r)
    if (!(std::fabs(z[r] - z_other[r]) <= 1e-3F * (1.0F + std::fabs(z_other[r])))) return false;
  return one.monitor.armed() == other.monitor.armed() && one.monitor.alarm() == other.monitor.alarm() &&
         one.observer.status() == other.observer.status() &&
         std::fabs(one.monitor.level() - other.monitor.level()) <= 1e-2F * (1.0F + other.monitor.level());
}

struct Counts {
  int reported = 0, harmless = 0, silent = 0, lasting = 0, resets = 0;
};

template <class Observer>
void upset(const Observer& fresh, int flips, Counts& counts) {
  static const auto watching = monitor_model<Observer>();
  using P = Pair<Observer>;
  P twin{fresh, typename P::Watch{watching}}, other = twin;
  std::mt19937 engine(11);
  int k = 0, alarms = 0;
  for (; k < 2 * kPeriod; ++k) {
    twin.fly(k);
    alarms += twin.monitor.alarm() != Alarm::kNone;
    const int since_fault = (k + kFault) % kPeriod;  // including its effect on the averages
    ASSERT_TRUE(twin.monitor.alarm() == Alarm::kNone || since_fault < kFault + 100) << k;
  }
  ASSERT_GT(alarms, kFault / 2) << "control: the fault is seen";
  for (int flip = 0; flip < flips; ++flip) {
    for (int wait = static_cast<int>(engine() % kPeriod); wait > 0; --wait) twin.fly(k++);
    other = twin;
    const std::size_t bit = engine() % (P::kObserverBits + P::kMonitorBits);
    other.flip(bit);
    bool reported = other.observer.status() == StepStatus::kReset;
    int since = 0, apart = 0;  // samples since the flip, and the last of them with a difference
    for (; since - apart < kPeriod && since < kSettled; ++since, ++k) {
      twin.fly(k);
      other.fly(k);
      reported = reported || other.status != twin.status ||
                 (other.monitor.alarm() != Alarm::kNone && twin.monitor.alarm() == Alarm::kNone);
      counts.resets += other.monitor.alarm() == Alarm::kReset;
      if (!together(other, twin)) apart = since;
    }
    const bool healed = since - apart >= kPeriod;  // equal over a whole period, including its fault
    counts.reported += reported && healed;
    counts.harmless += !reported && healed;
    counts.silent += !reported && !healed;
    counts.lasting += reported && !healed;
    EXPECT_TRUE(healed) << (reported ? "reported" : "silent") << ", bit " << bit % 8 << " of byte "
                        << (bit < P::kObserverBits ? bit : bit - P::kObserverBits) / 8 << " of the "
                        << (bit < P::kObserverBits ? "observer" : "monitor") << ", at sample " << k - since;
    for (P* each : {&twin, &other})
      EXPECT_TRUE(!healed ||
                  (each->observer.restore(each->observer.save()) && each->monitor.restore(each->monitor.save())))
          << "it must accept its own saved state";
  }
}

TEST(Upset, NoneOfTwentyThousandBitFlipsIsSilentOrPermanent) {
  Counts counts;
  testing::each_structure<float>([&](const auto& observer) { upset(observer, kFlips / kStructures + 1, counts); });
  EXPECT_EQ(counts.silent, 0);
  EXPECT_EQ(counts.lasting, 0);
  EXPECT_GT(counts.reported, 900) << "control: flips are detected";
  EXPECT_GT(counts.harmless, 1000) << "control: flips of the lowest bits have no effect";
  EXPECT_GT(counts.resets, 100) << "control: the monitor was reset";
  RecordProperty("reported", counts.reported);
  std::printf("reported %d, harmless %d, silent %d, resets %d\n", counts.reported, counts.harmless, counts.silent,
              counts.resets);
}

/// If z does not change, it does not show a corrupted reading. But T* of angles also reads y, and would compute an
/// estimate from NaN.
TEST(Upset, DetectsANanReadingInMemoryWithoutAGoodMeasurement) {
  static const auto model = testing::undriven_model<float>(Hold::kFirstOrder);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  using Observer = KklObserver<testing::UndrivenTestModel<float>>;
  const auto corrupt = [&](Observer& observer) {  // flips bits of its exponent
    auto* bytes = reinterpret_cast<unsigned char*>(&observer) + sizeof(void*) + offsetof(Observer::State, y);
    std::memcpy(bytes, &kNan, sizeof kNan);
  };
  for (const bool warm : {false, true}) {
    Observer observer(model);
    if (warm) {
      ASSERT_EQ(observer.step(1.0F), StepStatus::kOk);
    }
    const auto next = [&] { return warm ? observer.warm_start(kNan) : observer.step(kNan); };
    EXPECT_EQ(next(), StepStatus::kHeld) << "control: without a flip";
    corrupt(observer);
    EXPECT_EQ(next(), StepStatus::kReset) << (warm ? "warm start" : "first step");
    EXPECT_EQ(observer.step(1.0F), StepStatus::kOk) << "the next measurement counts as the first";
  }
}

/// An angle is unwrapped next to the last one, but at a start there is no last one.
TEST(Upset, AStartDoesNotUseACorruptedAngle) {
  static const auto model = testing::angle_model<float>();
  using Observer = KklObserver<std::remove_const_t<decltype(model)>>;
  for (const float flipped : {std::numeric_limits<float>::quiet_NaN(), 1e38F}) {
    const auto corrupt = [&](Observer& observer) {
      auto* bytes = reinterpret_cast<unsigned char*>(&observer) + sizeof(void*) + offsetof(Observer::State, y);
      std::memcpy(bytes, &flipped, sizeof flipped);
    };
    Observer cold(model), warm(model), twin(model);
    corrupt(cold);
    EXPECT_EQ(cold.step({{1.0F, 0.5F}}), StepStatus::kReset) << flipped;
    EXPECT_EQ(cold.step({{1.0F, 0.5F}}), StepStatus::kOk) << "the next measurement counts as the first";
    ASSERT_EQ(warm.step({{3.0F, 0.5F}}), StepStatus::kOk);
    corrupt(warm);
    ASSERT_EQ(twin.warm_start({{1.0F, 0.5F}}), StepStatus::kOk);
    EXPECT_EQ(warm.warm_start({{1.0F, 0.5F}}), StepStatus::kOk);
    EXPECT_TRUE(testing::same_bits(warm.save(), twin.save())) << "the past has no effect: " << flipped;
    ASSERT_EQ(warm.step({{4.0F, 0.5F}}), StepStatus::kHeld) << "out of range";
    corrupt(warm);
    EXPECT_EQ(warm.step({{4.0F, 0.5F}}), StepStatus::kReset) << "a held reading must be a measured one: " << flipped;
  }
}

}  // namespace
}  // namespace nlo
