// SPDX-License-Identifier: MIT
// Known delays are found, no delay is found if there is none, and logs that do not determine a delay are recognised.
// [[log.columns]] delay_s: the loader shifts u to the time at which it acts.
#include "trainer/data/delay_search.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "tests/data/data_testing.h"
#include "trainer/data/log_dataset.h"
#include "trainer/data/log_delays.h"
#include "trainer/data/product_search.h"

namespace nlo::trainer {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kRight = 0.1;    // samples
constexpr double kLongest = 8.0;  // samples; the program tries up to 32, which takes minutes with sanitizers
constexpr double kFind = std::numeric_limits<double>::quiet_NaN();

/// x1' = x2, x2' = -9 sin x1 - 0.4 x2 + 6 (gain) u(t - d) at 50 Hz, by midpoint steps. u either steps every 12 samples,
/// as held commands do (zero_order), or is low-passed and linear between samples. The position (relative degree 2) or
/// the speed is measured.
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

TEST(DelaySearch, FindsNoDelayIfThereIsNone) {
  for (const Hold hold : {Hold::kZeroOrder, Hold::kFirstOrder})
    for (const bool position : {true, false})
      EXPECT_NEAR((PushedPendulum{.delay = 0.0, .position = position, .hold = hold}.found().samples), 0.0, kRight);
}

TEST(DelaySearch, FindsTheDelayDespiteNoise) {
  EXPECT_NEAR((PushedPendulum{.delay = 2.4, .noise = 0.001}.found().samples), 2.4, kRight);
  EXPECT_NEAR((PushedPendulum{.delay = 2.4, .noise = 0.01, .position = false}.found().samples), 2.4, kRight);
}

TEST(DelaySearch, ReportsAnInputWithoutEffect) {
  try {
    const FoundDelay found = PushedPendulum{.delay = 2.4, .noise = 0.01, .gain = 0.0}.found();
    EXPECT_GT(found.deviation, 0.5) << "found " << found.samples << " where u does nothing";
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("has no effect on any measurement"), std::string::npos);
  }
}

TEST(DelaySearch, FindsADelayForEachOfTwoInputs) {
  std::vector<DelayRun> first = PushedPendulum{.delay = 3.25}.runs();
  for (DelayRun& run : first) {  // a second input, with a quantity that follows it without delay
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

constexpr double kRow_s = 0.01;

TEST(Delayed, ShiftsARampAndASinusoidByAFractionOfASample) {
  const Eigen::VectorXd time_s = Eigen::VectorXd::LinSpaced(400, 0.0, 3.99);
  const double delay_s = 0.0237;
  const Eigen::VectorXd ramp = delayed(time_s, 3.0 * time_s, delay_s),
                        wave = delayed(time_s, (5.0 * time_s.array()).sin().matrix(), delay_s);
  constexpr double kChord = 5.0 * 5.0 * kRow_s * kRow_s / 8.0;  // largest error of linear interpolation
  for (Eigen::Index k = 3; k < time_s.size(); ++k) {
    ASSERT_NEAR(ramp[k], 3.0 * (time_s[k] - delay_s), 1e-12);
    ASSERT_NEAR(wave[k], std::sin(5.0 * (time_s[k] - delay_s)), 1.001 * kChord);
  }
  EXPECT_EQ(ramp[0], 0.0);
  EXPECT_EQ(ramp[2], 0.0);  // before the first sample, its value is used
}

TEST(Delayed, UsesUnevenTimeStamps) {
  Eigen::VectorXd time_s(4), values(4);
  time_s << 0.0, 1.0, 1.5, 4.0;
  values << 0.0, 2.0, 3.0, 8.0;  // 2 t
  const Eigen::VectorXd late = delayed(time_s, values, 0.75);
  EXPECT_DOUBLE_EQ(late[1], 0.5);
  EXPECT_DOUBLE_EQ(late[2], 1.5);
  EXPECT_DOUBLE_EQ(late[3], 6.5);
}

/// y' = 4 (u - y) with u held: step commands that act 2.6 rows late, or at once.
class LogDelays : public ::testing::Test {
 protected:
  void write_log(double late) {
    std::string text = "t,y,u\n";
    double y = 0.0;
    const auto command = [](int k) { return std::sin(0.9 * (k / 9)) + ((k / 9) % 3 == 0 ? 1.0 : 0.0); };
    for (int k = 0; k < 1500; ++k) {
      char line[80];
      std::snprintf(line, sizeof line, "%.3f,%.9g,%.9g\n", kRow_s * k, y, command(k));
      text += line;
      constexpr int kPieces = 50;
      for (int i = 0; i < kPieces; ++i)
        y += kRow_s / kPieces * 4.0 *
             (command(std::max(0, static_cast<int>(std::ceil(k + (i + 0.5) / kPieces - late)))) - y);
    }
    scratch_.write("log.csv", text);
  }
  static LogConfig config() {
    LogConfig log;
    log.columns = {column("t", ColumnRole::kTime, {.column = "t"}), column("y", ColumnRole::kOutput, {.column = "y"}),
                   column("x", ColumnRole::kState, {.column = "y"}), column("u", ColumnRole::kInput, {.column = "u"})};
    log.train_files = {"log.csv"};
    return log;
  }

  ScratchDirectory scratch_;
};

TEST_F(LogDelays, ShiftTheColumnByTheDelay) {
  write_log(0.0);
  LogConfig log = config();
  const Dataset plain = load_logs(log, scratch_.path(), {"log.csv"});
  log.columns[3].delay_s = 2.5 * kRow_s;
  const Dataset late = load_logs(log, scratch_.path(), {"log.csv"});
  const auto& before = plain.trajectories[0].inputs;
  const auto& after = late.trajectories[0].inputs;
  for (Eigen::Index k = 3; k < after.cols(); ++k)
    ASSERT_NEAR(after(0, k), 0.5 * (before(0, k - 2) + before(0, k - 3)), 1e-9);
  EXPECT_EQ(late.trajectories[0].outputs, plain.trajectories[0].outputs);
}

TEST_F(LogDelays, AreEstimatedFromTheTrainingLogsAndStoredInTheColumn) {
  for (const double late : {0.0, 2.6}) {
    write_log(late);
    LogConfig log = config();
    log.columns[3].find_delay = true;
    const auto found = find_log_delays(log, scratch_.path(), Hold::kZeroOrder);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_NEAR(found[0].samples(), late, 0.1);
    EXPECT_EQ(log.columns[3].delay_s, found[0].delay_s);
    EXPECT_FALSE(log.columns[3].find_delay);
    EXPECT_THAT(to_text(found[0]), HasSubstr(late > 0.0 ? "later than its column shows" : "u acts"));
  }
}

TEST_F(LogDelays, MustBeKnownWhenALogIsReadAndBelongToInputs) {
  write_log(0.0);
  LogConfig log = config();
  log.columns[3].find_delay = true;
  EXPECT_THAT(thrown_message([&] { load_logs(log, scratch_.path(), {"log.csv"}); }),
              AllOf(HasSubstr("\"u\""), HasSubstr("write the delay in seconds")));
  log = config();
  log.columns[1].delay_s = 0.01;
  EXPECT_THAT(thrown_message([&] { load_logs(log, scratch_.path(), {"log.csv"}); }),
              AllOf(HasSubstr("\"y\""), HasSubstr("role \"input\"")));
}

TEST(DelaysInFlight, AreInSamplesOfTheObserver) {
  LogConfig log;
  log.columns = {column("u", ColumnRole::kInput), column("w", ColumnRole::kInput), column("v", ColumnRole::kInput)};
  log.columns[0].delay_s = 0.025;
  log.columns[2].delay_s = 0.03;
  EXPECT_EQ(delays_in_flight(log, 0.01), "u 2.5, v 3");
  EXPECT_EQ(delays_in_flight(LogConfig{}, 0.01), "");
}

/// Logs of two outputs and an input that vary independently; x is the function `state` of them plus a little noise.
Dataset wandering_logs(int logs, const std::function<double(double a, double b, double u)>& state) {
  Dataset data;
  data.outputs = {{"a", "", 0.0}, {"b", "", 0.0}};
  data.inputs = {{"u", "", 0.0}};
  data.states = {{"x", "", 0.0}};
  data.reads_inputs = true;
  data.sample_period_s = 0.1;
  for (int log = 0; log < logs; ++log) {
    Trajectory run;
    constexpr int kSamples = 400;
    run.source = run.log = "log" + std::to_string(log);
    run.time_s = Eigen::VectorXd::LinSpaced(kSamples, 0.0, 0.1 * (kSamples - 1));
    run.outputs.resize(2, kSamples);
    run.inputs.resize(1, kSamples);
    run.states.resize(1, kSamples);
    run.weight = Eigen::VectorXd::Ones(kSamples);
    for (int k = 0; k < kSamples; ++k) {
      const double t = run.time_s[k] + 7.0 * log;
      const double a = 2.0 + std::sin(0.9 * t) + 0.3 * std::cos(2.3 * t), b = std::sin(0.53 * t + 1.0) - 0.4,
                   u = std::cos(1.7 * t);
      run.outputs.col(k) << a, b;
      run.inputs(0, k) = u;
      run.states(0, k) = state(a, b, u) + 0.01 * std::sin(97.0 * t * t);
    }
    data.trajectories.push_back(std::move(run));
  }
  return data;
}

TEST(ProductSearch, FindsTheProductsInAState) {
  const auto found =
      find_products(wandering_logs(4, [](double a, double b, double u) { return a * u + 0.5 * b * b + a; }));
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].expression, "a * u");  // the product with the larger share
  EXPECT_EQ(found[0].name, "a_u");
  EXPECT_EQ(found[1].expression, "b^2");
  EXPECT_EQ(found[1].name, "b_squared");
  EXPECT_GT(found[0].gain, 0.3);
}

TEST(ProductSearch, FindsNoneIfASumOfChannelsIsAsAccurate) {
  EXPECT_TRUE(find_products(wandering_logs(4, [](double a, double b, double u) { return a - 2.0 * b + u; })).empty());
}

TEST(ProductSearch, FindsNoneInTooFewLogs) {
  const auto product = [](double a, double, double u) { return a * u; };
  EXPECT_TRUE(find_products(wandering_logs(2, product)).empty());
  EXPECT_FALSE(find_products(wandering_logs(3, product)).empty());  // control
}

TEST(ProductSearch, UsesNeitherWrappedAnglesNorComputedOutputs) {
  Dataset data = wandering_logs(4, [](double a, double, double u) { return a * u; });
  data.outputs[0].wrap = 6.28;
  EXPECT_TRUE(find_products(data).empty() || find_products(data)[0].expression.find('a') == std::string::npos);
  data.outputs[0] = {"a", "", 0.0};
  data.outputs[1] = {"b", "", 0.0, "a^2"};
  for (const FoundProduct& product : find_products(data)) EXPECT_EQ(product.expression.find('b'), std::string::npos);
}

}  // namespace
}  // namespace nlo::trainer
