// SPDX-License-Identifier: MIT
#include "trainer/data/evaluation_windows.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "trainer/data/transient.h"

namespace nlo::trainer {
namespace {

struct Plant {
  std::string name;
  std::vector<double> eigenvalues;
  std::vector<std::array<double, 2>> pairs;
  double horizon_s, transient_s;
};

ObserverConfig observer_of(const Plant& plant) {
  ObserverConfig observer;
  observer.eigenvalues = plant.eigenvalues;
  observer.pairs = plant.pairs;
  return observer;
}

TEST(EvaluationWindows, FitTheSlowestTimeConstantAndTheHorizon) {
  const std::vector<Plant> plants = {
      {"a motor", {-200.0, -1000.0}, {}, 0.5, 0.025},
      {"an oscillator", {-1.0, -4.0}, {{-0.3, 0.9}}, 50.0, 16.0},
      {"an epidemic in days", {-0.25, -1.0}, {}, 120.0, 20.0},
      {"a battery", {-0.001, -0.1}, {}, 36000.0, 5000.0},
      {"one that never settles", {-0.01}, {}, 50.0, 25.0},  // 500 s would leave nothing of the horizon
  };
  for (const Plant& plant : plants) {
    const EvaluationWindows windows = evaluation_windows({}, decay_rate(observer_of(plant)), plant.horizon_s);
    ASSERT_EQ(windows.size(), 3U) << plant.name;
    EXPECT_EQ(windows[0].name, "all");
    EXPECT_EQ(windows[1].to_s, plant.transient_s) << plant.name;
    EXPECT_EQ(windows[2].from_s, plant.transient_s) << plant.name;
    EXPECT_EQ(settled_window(windows), 2U);
    EXPECT_DOUBLE_EQ(settling_window_s({}, windows, plant.horizon_s), plant.transient_s / 10.0);
  }
}

TEST(EvaluationWindows, WithoutEigenvaluesTheHorizonDecidesAlone) {
  EXPECT_EQ(evaluation_windows({}, decay_rate({}), 50.0)[2].from_s, 10.0);
}

TEST(EvaluationWindows, ConfiguredOnesReplaceTheDerived) {
  EvaluationConfig config;
  config.windows = {{"early", 0.5, 5.0}, {"late", 2.0, std::numeric_limits<double>::infinity()}};
  const EvaluationWindows windows = evaluation_windows(config, 0.0, 50.0);
  ASSERT_EQ(windows.size(), 3U);
  EXPECT_EQ(settled_window(windows), 2U) << "the first that lasts to the end";
  EXPECT_EQ(window_text(windows[0]), "all");
  EXPECT_EQ(window_text(windows[1]), "early (0.5-5 s)");
  EXPECT_EQ(window_text(windows[2]), "late (t >= 2 s)");
  config.windows.pop_back();
  EXPECT_EQ(settled_window(evaluation_windows(config, 0.0, 50.0)), 0U) << "none lasts";
  config.settling_window_s = 0.3;
  EXPECT_EQ(settling_window_s(config, windows, 50.0), 0.3);
}

}  // namespace
}  // namespace nlo::trainer
