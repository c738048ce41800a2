// SPDX-License-Identifier: MIT
// Compares the monitor of an exported header with its equations on the same measurements.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlo/kkl_observer.h>
#include <nlo/monitor.h>

#include <cmath>
#include <limits>
#include <random>

#include "codegen/replay/reference_monitor.h"
#include "codegen/replay/reference_observer.h"
#include "tests/codegen/example_models.h"
#include "tests/golden/watched.h"

namespace nlo::codegen {
namespace {

using Flown = KklObserver<watched::Model>;

/// A wave with noise, outliers, a burst of missing samples, a frozen part, and a part with a bias.
std::vector<float> measurements() {
  std::mt19937 engine(3);
  std::normal_distribution<float> noise(0.0F, 0.1F);
  std::vector<float> y(1200);
  for (std::size_t k = 0; k < y.size(); ++k) {
    y[k] = 0.5F * std::sin(0.05F * static_cast<float>(k)) + noise(engine);
    if (k % 97 == 50) y[k] += 6.0F;
    if (k > 500 && k < 540) y[k] = std::numeric_limits<float>::quiet_NaN();
    if (k > 620 && k < 680) y[k] = y[620];
    if (k > 800) y[k] += 0.7F * std::sin(0.4F * static_cast<float>(k));
  }
  return y;
}

TEST(WatchedFlight, HeaderAndReferenceAgree) {
  const Model model = watched_model();
  Flown observer{watched::kModel};
  watched::Monitor monitor{watched::kMonitor};
  ReferenceObserver<double> reference(model);
  ReferenceMonitor watch(model, *model.monitor);
  int alarms = 0, rejected = 0, different = 0;
  double furthest = 0.0;
  for (const float y : measurements()) {
    const float kept = monitor.usable_outputs(y, observer);
    (void)observer.step(kept);
    const Alarm alarm = monitor.watch(observer, observer.estimate());
    const Eigen::VectorXd given = Eigen::VectorXd::Constant(1, static_cast<double>(y));
    const Eigen::VectorXd screened = watch.usable_outputs(given);
    reference.step(screened);
    watch.watch(reference.latent(), reference.output(), reference.estimate(), {reference.status(Eigen::Index{0})});
    ASSERT_EQ(std::isnan(kept), std::isnan(screened(0)));
    const double level = watch.levels().maxCoeff();
    furthest = std::max(furthest, std::abs(static_cast<double>(monitor.level()) - level) / (1.0 + level));
    different += alarm == watch.alarm() ? 0 : 1;
    alarms += alarm != Alarm::kNone ? 1 : 0;
    rejected += std::isnan(kept) && !std::isnan(y) ? 1 : 0;
  }
  // 1,200 steps in float through averages that forget: about a hundred roundings of 6e-8 remain.
  EXPECT_LT(furthest, 2e-5);
  EXPECT_EQ(different, 0);
  // Control: the flight contains faults.
  EXPECT_GT(alarms, 20);
  EXPECT_LT(alarms, 1100);
  EXPECT_GE(rejected, 8 + 30);  // a sensor is frozen from its 30th repetition on
}

/// The golden model with an output at a fifth of the rate.
struct Slow : watched::Model {
  static constexpr std::uint16_t kNotDue[kNr] = {4};
};
constexpr Slow kSlow{watched::kModel};

TEST(WatchedFlight, HeaderAndReferenceAgreeForASlowOutput) {
  Model model = watched_model();
  model.outputs[0].period_s = 5.0 * model.sample_period_s;
  for (const bool gate : {true, false}) {
    KklObserver<Slow> observer{kSlow};
    watched::Monitor monitor{watched::kMonitor};
    ReferenceObserver<double> reference(model);
    ReferenceMonitor watch(model, *model.monitor);
    int different = 0, missing = 0, others = 0;
    double furthest = 0.0;
    std::vector<float> readings = measurements();
    for (std::size_t k = 0; k < readings.size(); ++k) {
      const float y = k % 5 == 0 ? readings[k] : std::numeric_limits<float>::quiet_NaN();
      const Eigen::VectorXd given = Eigen::VectorXd::Constant(1, static_cast<double>(y));
      const float kept = gate ? monitor.usable_outputs(y, observer) : y;
      const Eigen::VectorXd screened = gate ? watch.usable_outputs(given) : given;
      ASSERT_EQ(std::isnan(kept), std::isnan(screened(0))) << k;
      (void)observer.step(kept);
      reference.step(screened);
      ASSERT_EQ(observer.has_arrived(0), !std::isnan(kept)) << k;
      ASSERT_EQ(reference.has_arrived(0), !std::isnan(kept)) << k;
      const Alarm alarm = monitor.watch(observer, observer.estimate());
      watch.watch(reference.latent(), reference.output(), reference.estimate(), {reference.status(Eigen::Index{0})},
                  {reference.has_arrived(0)});
      const double level = watch.levels().maxCoeff();
      furthest = std::max(furthest, std::abs(static_cast<double>(monitor.level()) - level) / (1.0 + level));
      different += alarm == watch.alarm() ? 0 : 1;
      missing += alarm == Alarm::kMissing ? 1 : 0;
      others += alarm != Alarm::kNone && alarm != Alarm::kMissing ? 1 : 0;
      if (!gate && k > 20 && k < 500) {
        ASSERT_NE(alarm, Alarm::kMissing) << k << ": no sample is due in between";
      }
    }
    EXPECT_LT(furthest, 2e-5);  // rounding, as in the test above
    EXPECT_EQ(different, 0);
    EXPECT_GT(missing, 10) << "control: 40 samples are missing";
    EXPECT_GT(others, 20) << "control: the flight contains faults";
  }
}

TEST(WatchedFlight, ARunEqualsItsSteps) {
  const Model model = watched_rig_model();
  const Eigen::Index samples = 300;
  Eigen::MatrixXd y(2, samples);
  for (Eigen::Index k = 0; k < samples; ++k) {
    const double t = static_cast<double>(k);
    y.col(k) << std::remainder(0.08 * t, 2.0 * std::numbers::pi), std::sin(0.1 * t);  // the angle makes full turns
  }
  const WatchedRun run = watched_run(model, *model.monitor, y, {});
  ReferenceObserver<float> observer(model);
  ReferenceMonitor watch(model, *model.monitor);
  for (Eigen::Index k = 0; k < samples; ++k) {
    observer.step(watch.usable_outputs(y.col(k)));
    watch.watch(observer.latent().cast<double>(), observer.output(), observer.estimate().cast<double>(),
                {observer.status(Eigen::Index{0}), observer.status(Eigen::Index{1})});
    ASSERT_TRUE(watch.levels().isApprox(run.levels.col(k), 1e-12) || k == 0) << k;
  }
  const WatchedRun open = watched_run(model, *model.monitor, y, {}, {}, Gate::kNotUsed);
  EXPECT_EQ(open.run.x_hat, run.run.x_hat) << "a gate that rejects nothing has no effect";
  EXPECT_EQ(run.armed_after, 10);
  EXPECT_TRUE(run.levels.allFinite());
  // A wrap must not count as a jump: the innovation would then be 2 pi divided by a deviation of .2, and rejected.
  EXPECT_EQ(run.rejected, 0);
}

}  // namespace
}  // namespace nlo::codegen
