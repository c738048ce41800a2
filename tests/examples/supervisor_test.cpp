// SPDX-License-Identifier: MIT
// An observer supervised by a filter: the exported observer and monitor of tests/golden/watched.h, which estimate a
// wave from itself, and a filter whose estimates the test sets.
#include "examples/supervisor/supervisor.h"

#include <gtest/gtest.h>
#include <nlo/kkl_observer.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/golden/watched.h"

namespace nlo::examples {
namespace {

using Output = watched::Monitor::Output;
using Estimate = watched::Monitor::Estimate;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// A filter that returns the estimates that the test sets.
struct GivenFilter {
  float value = 10.0F;
  void step(const Output&) {}
  Estimate estimate() const { return {{value}}; }
};

class SupervisorTest : public testing::Test {
 protected:
  /// Returns one sample of the wave for which the observer was made.
  float wave() { return 0.5F * std::sin(0.05F * static_cast<float>(k_++)); }
  float step(float y) { return supervisor_.step({{y}})[0]; }

  /// Steps until the observer is in its domain and no fault is counted.
  void settle() {
    for (int i = 0; i < 600; ++i) (void)step(wave());
    ASSERT_EQ(supervisor_.source(), Source::kObserver);
    ASSERT_EQ(supervisor_.alarm(), Alarm::kNone);
  }

  /// Returns how many samples of `y` pass until the source is `wanted`; -1: never.
  int samples_until(Source wanted, float y, std::vector<float>* estimates = nullptr) {
    for (int i = 0; i < 5000; ++i) {
      const float x_hat = step(std::isfinite(y) || std::isnan(y) ? y : wave());
      if (estimates != nullptr) estimates->push_back(x_hat);
      if (supervisor_.source() == wanted) return i + 1;
    }
    return -1;
  }

  static constexpr float kWave = std::numeric_limits<float>::infinity();  ///< stands for a sample of the wave

  SupervisorConfig config_{.patience = 3, .probation = 40, .fade = 0.9};
  watched::Observer observer_{watched::kModel};
  watched::Monitor monitor_{watched::kMonitor};
  GivenFilter filter_;
  Supervisor<watched::Observer, watched::Monitor, GivenFilter> supervisor_{observer_, monitor_, filter_, config_};
  int k_ = 0;
};

TEST_F(SupervisorTest, UsesTheObserversEstimateBitForBitWithoutAFault) {
  watched::Observer alone{watched::kModel};
  for (int i = 0; i < 300; ++i) {
    const float y = wave();
    (void)alone.step(y);
    ASSERT_EQ(step(y), alone.estimate()[0]) << i;
  }
}

TEST_F(SupervisorTest, ADeadSensorHandsOverToTheFilterAndTheObserverReturnsAfterItsProbation) {
  settle();
  ASSERT_GT(samples_until(Source::kFilter, kNan), 0);
  EXPECT_GE(samples_until(Source::kObserver, kWave), config_.probation);
}

TEST_F(SupervisorTest, TheEstimateDoesNotJumpAtAHandOverAndItsOffsetFadesGeometrically) {
  settle();
  float before = step(wave());
  ASSERT_GT(samples_until(Source::kFilter, kNan), 0);
  float offset = supervisor_.offset()[0];
  EXPECT_GT(std::abs(offset), 5.0F) << "the filter says 10, the wave stays below 1";
  for (int i = 0; i < 20; ++i) {
    before = step(kNan);
    offset *= 0.9F;
    EXPECT_NEAR(supervisor_.offset()[0], offset, 1e-5F);
    EXPECT_NEAR(before, filter_.value + offset, 1e-4F);
  }
}

// Control: without fading, the estimate jumps by the whole difference, one sample later.
TEST_F(SupervisorTest, WithoutFadingTheEstimateJumpsAfterOneSample) {
  config_.fade = 0.0;
  Supervisor<watched::Observer, watched::Monitor, GivenFilter> abrupt{observer_, monitor_, filter_, config_};
  for (int i = 0; i < 600; ++i) (void)abrupt.step({{wave()}});
  float last = 0.0F, jump = 0.0F;
  for (int i = 0; i < 5000 && jump < 1.0F; ++i) {
    const float now = abrupt.step({{kNan}})[0];
    jump = i == 0 ? 0.0F : std::abs(now - last);
    last = now;
  }
  EXPECT_GT(jump, 5.0F);
}

TEST_F(SupervisorTest, AnyInputGivesTheLoopAFiniteEstimateWithoutAJumpBeyondTheOffset) {
  settle();
  const float hostile[] = {kNan, 1e30F, -1e30F, 0.0F, 3.0F, -3.0F, std::numeric_limits<float>::infinity()};
  float last = step(wave());
  for (int i = 0; i < 3000; ++i) {
    const float now = step(hostile[(i / 7) % 7]);
    ASSERT_TRUE(std::isfinite(now)) << i;
    ASSERT_LT(std::abs(now - last), 4.0F)
        << i;  // a tenth of an offset of 13, plus the motion of the observer on clamped readings
    last = now;
  }
}

TEST_F(SupervisorTest, ANonFiniteFilterIsNotUsedIfTheObserverIsFinite) {
  settle();
  filter_.value = kNan;
  for (int i = 0; i < 200; ++i) ASSERT_TRUE(std::isfinite(step(i % 3 == 0 ? 2.9F : wave()))) << i;
  EXPECT_EQ(supervisor_.source(), Source::kObserver);
}

}  // namespace
}  // namespace nlo::examples
