// SPDX-License-Identifier: MIT
// A delay that is known is found again, none is found where there is none, and logs that do not say are told apart.
#include "trainer/data/delay_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace nlo::trainer {
namespace {

constexpr double kRight = 0.1;    // samples
constexpr double kLongest = 8.0;  // samples; the program tries 32, which takes minutes under sanitizers
constexpr double kFind = std::numeric_limits<double>::quiet_NaN();

/// x1' = x2, x2' = -9 sin x1 - 0.4 x2 + 6 (gain) u(t - d) at 50 Hz, by midpoint steps; u in steps of 12 samples, as
/// commands are held (zero_order), or low-passed and linear between samples. Measured:
/// the position (relative degree 2) or the speed.
struct PushedPendulum {
  double delay = 0.0, noise = 0.0, gain = 1.0;
  bool position = true;
  Hold hold = Hold::kZeroOrder;

  std::vector<DelayRun> runs() const {
    constexpr int kSamples = 1000, kPieces = 20;
    constexpr double kStep_s = 0.02 / kPieces;
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    std::vector<DelayRun> all;
    for (int r = 0; r < 2; ++r) {
      DelayRun run{Eigen::MatrixXd(1, kSamples), Eigen::MatrixXd(1, kSamples)};
      double level = 0.0, smooth = 0.0;
      for (int k = 0; k < kSamples; ++k) {
        if (k % 12 == 0) level = 2.0 * uniform(random);
        smooth += 0.2 * (level - smooth);
        run.inputs(0, k) = hold == Hold::kZeroOrder ? level : smooth;
      }
      const auto input = [&](double t) {
        const double inside = std::clamp(t, 0.0, kSamples - 1.001);
        const auto k = static_cast<int>(inside);
        if (hold == Hold::kZeroOrder) return run.inputs(0, static_cast<int>(std::ceil(inside)));
        return run.inputs(0, k) + (inside - k) * (run.inputs(0, k + 1) - run.inputs(0, k));
      };
      Eigen::Vector2d x(uniform(random), uniform(random));
      for (int k = 0; k < kSamples; ++k) {
        run.measured(0, k) = (position ? x(0) : x(1)) + noise * normal(random);
        for (int piece = 0; piece < kPieces; ++piece) {
          const double u = gain * input(k + (piece + 0.5) / kPieces - delay);
          const auto slope = [&](const Eigen::Vector2d& at) {
            return Eigen::Vector2d(at(1), -9.0 * std::sin(at(0)) - 0.4 * at(1) + 6.0 * u);
          };
          x += kStep_s * slope(x + 0.5 * kStep_s * slope(x));
        }
      }
      all.push_back(std::move(run));
    }
    return all;
  }

  FoundDelay found() const { return find_delays(runs(), {0.0}, {kFind}, hold, kLongest).front(); }
};

TEST(DelaySearch, FindsAFractionalDelayToATenthOfASample) {
  for (const Hold hold : {Hold::kZeroOrder, Hold::kFirstOrder})
    for (const bool position : {true, false}) {
      const FoundDelay found = PushedPendulum{.delay = 2.4, .position = position, .hold = hold}.found();
      EXPECT_NEAR(found.samples, 2.4, kRight) << position;
      EXPECT_LT(found.deviation, kRight);
      EXPECT_LT(found.with, 0.5 * found.without);
    }
}

TEST(DelaySearch, FindsNoneWhereThereIsNone) {
  for (const Hold hold : {Hold::kZeroOrder, Hold::kFirstOrder})
    for (const bool position : {true, false})
      EXPECT_NEAR((PushedPendulum{.delay = 0.0, .position = position, .hold = hold}.found().samples), 0.0, kRight);
}

TEST(DelaySearch, BearsNoise) {
  EXPECT_NEAR((PushedPendulum{.delay = 2.4, .noise = 0.001}.found().samples), 2.4, kRight);
  EXPECT_NEAR((PushedPendulum{.delay = 2.4, .noise = 0.01, .position = false}.found().samples), 2.4, kRight);
}

TEST(DelaySearch, SaysWhenAnInputMovesNothing) {
  try {
    const FoundDelay found = PushedPendulum{.delay = 2.4, .noise = 0.01, .gain = 0.0}.found();
    EXPECT_GT(found.deviation, 0.5) << "found " << found.samples << " where u does nothing";
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("moves nothing"), std::string::npos);
  }
}

TEST(DelaySearch, TwoInputsHaveDelaysOfTheirOwn) {
  std::vector<DelayRun> first = PushedPendulum{.delay = 3.25}.runs();
  for (DelayRun& run : first) {  // a second input, which one more quantity follows at once
    Eigen::MatrixXd both(2, run.inputs.cols()), measured(2, run.inputs.cols());
    both << run.inputs, run.inputs.rowwise().reverse();
    measured << run.measured, Eigen::RowVectorXd::Zero(run.inputs.cols());
    for (Eigen::Index k = 1; k < both.cols(); ++k)
      measured(1, k) = 0.9 * measured(1, k - 1) + 0.1 * both(1, k);  // y' = (u - y) / T, u held
    run = {measured, both};
  }
  const auto found = find_delays(first, {0.0, 0.0}, {kFind, kFind}, Hold::kZeroOrder, kLongest);
  EXPECT_NEAR(found[0].samples, 3.25, kRight);
  EXPECT_NEAR(found[1].samples, 0.0, kRight);
}

}  // namespace
}  // namespace nlo::trainer
