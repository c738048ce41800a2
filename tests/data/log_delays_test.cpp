// SPDX-License-Identifier: MIT
// [[log.columns]] delay_s: what is read of a log is u as it acts.
#include "trainer/data/log_delays.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "tests/data/testing.h"
#include "trainer/data/log_dataset.h"

namespace nlo::trainer {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kRow_s = 0.01;

TEST(Delayed, MovesARampAndASinusoidByAFraction) {
  const Eigen::VectorXd time_s = Eigen::VectorXd::LinSpaced(400, 0.0, 3.99);
  const double delay_s = 0.0237;
  const Eigen::VectorXd ramp = delayed(time_s, 3.0 * time_s, delay_s),
                        wave = delayed(time_s, (5.0 * time_s.array()).sin().matrix(), delay_s);
  constexpr double kChord = 5.0 * 5.0 * kRow_s * kRow_s / 8.0;  // of the line between samples
  for (Eigen::Index k = 3; k < time_s.size(); ++k) {
    ASSERT_NEAR(ramp[k], 3.0 * (time_s[k] - delay_s), 1e-12);
    ASSERT_NEAR(wave[k], std::sin(5.0 * (time_s[k] - delay_s)), 1.001 * kChord);
  }
  EXPECT_EQ(ramp[0], 0.0);
  EXPECT_EQ(ramp[2], 0.0);  // the first value stands for what came before
}

TEST(Delayed, TakesUnevenStampsAtTheirWord) {
  Eigen::VectorXd time_s(4), values(4);
  time_s << 0.0, 1.0, 1.5, 4.0;
  values << 0.0, 2.0, 3.0, 8.0;  // 2 t
  const Eigen::VectorXd late = delayed(time_s, values, 0.75);
  EXPECT_DOUBLE_EQ(late[1], 0.5);
  EXPECT_DOUBLE_EQ(late[2], 1.5);
  EXPECT_DOUBLE_EQ(late[3], 6.5);
}

/// y' = 4 (u - y), u held: commands of steps that act 2.6 rows late, or at once.
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

TEST_F(LogDelays, ReadsTheColumnThatMuchLater) {
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

TEST_F(LogDelays, AreFoundInTheTrainingLogsAndWrittenIntoTheColumn) {
  for (const double late : {0.0, 2.6}) {
    write_log(late);
    LogConfig log = config();
    log.columns[3].find_delay = true;
    const auto found = find_log_delays(log, scratch_.path(), Hold::kZeroOrder);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_NEAR(found[0].samples(), late, 0.1);
    EXPECT_EQ(log.columns[3].delay_s, found[0].delay_s);
    EXPECT_FALSE(log.columns[3].find_delay);
    EXPECT_THAT(to_text(found[0]), HasSubstr(late > 0.0 ? "after its column says" : "u acts"));
  }
}

TEST_F(LogDelays, MustBeKnownWhereALogIsReadAndBelongToInputs) {
  write_log(0.0);
  LogConfig log = config();
  log.columns[3].find_delay = true;
  EXPECT_THAT(error_of([&] { load_logs(log, scratch_.path(), {"log.csv"}); }),
              AllOf(HasSubstr("\"u\""), HasSubstr("write the delay in seconds")));
  log = config();
  log.columns[1].delay_s = 0.01;
  EXPECT_THAT(error_of([&] { load_logs(log, scratch_.path(), {"log.csv"}); }),
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

}  // namespace
}  // namespace nlo::trainer
