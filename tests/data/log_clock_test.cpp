// SPDX-License-Identifier: MIT
#include "trainer/data/log_clock.h"
#include "trainer/data/time_stamps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <random>
#include <sstream>
#include <string>

#include "tests/data/data_testing.h"
#include "trainer/data/clock_text.h"

namespace nlo::trainer {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using LogClock = LoadingLogs;

TEST_F(LogClock, UsesThePeriodOfTheStampsIfNoneIsGiven) {
  LogConfig config = SyntheticLog::config();
  config.sample_period_s = 0.0;
  EXPECT_NEAR(load(config, log_.csv()).sample_period_s, 0.005, 1e-6);  // 5 % of jitter, 600 samples
  EXPECT_EQ(report_.sample_period_s, load(config, log_.csv()).sample_period_s);
}

TEST_F(LogClock, MultipliesThePeriodOfTheRowsByTheKeyEvery) {
  LogConfig config = SyntheticLog::config();
  config.every = 4;
  config.sample_period_s = 0.0;
  EXPECT_NEAR(load(config, log_.csv()).sample_period_s, 0.02, 1e-5);  // jitter at the ends of the log
}

TEST_F(LogClock, IsUniformWithoutTimeStamps) {
  LogConfig config = SyntheticLog::config();
  config.columns.erase(config.columns.begin());
  const Dataset data = load(config, log_.csv());
  EXPECT_TRUE(data.uniform);
  EXPECT_NEAR(data.trajectories[0].time_s[100], 0.5, kPrinted);
}

TEST_F(LogClock, ReadsTimeInMilliseconds) {
  LogConfig config = SyntheticLog::config();
  config.columns[0].unit = "ms";
  EXPECT_THAT(error_in(config, log_.csv()),
              AllOf(HasSubstr("the median step is"), HasSubstr("unit of the time column")));
  config.sample_period_s = 0.0;
  config.velocity_filter.cutoff_hz = 2e4;
  config.velocity_filter.mask_edges_s = 2e-4;
  EXPECT_NEAR(load(config, log_.csv()).sample_period_s, 5e-6, 0.1 * 5e-6);
}

TEST_F(LogClock, ReportsTheClockOfEachFile) {
  load(SyntheticLog::config(), log_.csv());
  ASSERT_EQ(report_.files.size(), 1u);
  EXPECT_EQ(report_.files[0].samples, log_.samples);
  EXPECT_EQ(report_.data_hash.size(), 16u);
  EXPECT_THAT(to_text(report_), AllOf(HasSubstr("nominal sample period 5 ms"), HasSubstr("log.csv")));
}

TEST_F(LogClock, RefusesAColumnThatIsNotAClockAndNamesTheLine) {
  EXPECT_THAT(error_in(SyntheticLog::config(), "time,phi\n2,0\n2,1\n2,2\n"),
              HasSubstr("log.csv:3:time: time does not increase in 2 of 2 steps, here from 2 to 2"));
  EXPECT_THAT(error_in(SyntheticLog::config(), "time,phi\n2,0\n1,0\n"),
              HasSubstr("log.csv:3:time: time does not increase"));
  std::string shuffled = "time,phi\n";
  for (int k = 0; k < 100; ++k) shuffled += std::to_string(k * 37 % 101) + ",0\n";
  EXPECT_THAT(error_in(SyntheticLog::config(), shuffled), HasSubstr("is this column the clock?"));
}

/// 600 rows like those of the pendulum at 100 Hz, each with its own stamp and with the row number as reading.
std::string log_of(const std::function<std::string(int)>& stamp, int rows = 600) {
  std::string csv = "time,y\n";
  for (int k = 0; k < rows; ++k) csv += stamp(k) + "," + std::to_string(k) + "\n";
  return csv;
}

std::string printed(double time_s) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f", time_s);
  return text;
}

LogConfig plain_config() {
  LogConfig log;
  log.columns = {column("time", ColumnRole::kTime), column("y", ColumnRole::kOutput),
                 column("x", ColumnRole::kState, {.column = "y"})};
  return log;
}

TEST_F(LogClock, BeginsANewRunIfTheClockGoesBack) {
  const std::string csv = log_of([](int k) { return printed(0.01 * (k < 250 ? k : k - 250)); });
  for (const double max_gap_s : {0.0, 1e6}) {  // an allowed gap does not join two clocks
    LogConfig config = plain_config();
    config.max_gap_s = max_gap_s;
    const Dataset data = load(config, csv);
    ASSERT_EQ(data.trajectories.size(), 2u);
    EXPECT_TRUE(data.uniform);
    EXPECT_NEAR(data.sample_period_s, 0.01, 1e-9);
    EXPECT_EQ(data.trajectories[0].samples(), 250);
    EXPECT_EQ(data.trajectories[1].source, "log.csv (2 of 2)");
    EXPECT_EQ(data.trajectories[1].time_s[0], 0.0);
    EXPECT_EQ(data.trajectories[1].outputs(0, 0), 250.0);  // in the order of the file
    EXPECT_EQ(data.trajectories[1].outputs(0, 349), 599.0);
    EXPECT_THAT(report_.notes, ElementsAre(HasSubstr("log.csv:252: the clock goes back (0.000 follows 2.490), so a new "
                                                     "run begins there.")));
  }
  load(plain_config(), log_of([](int k) { return printed(0.01 * (k % 200)); }));
  EXPECT_EQ(report_.files[0].runs, 3u);
  EXPECT_THAT(report_.notes, ElementsAre(HasSubstr("(the first of 2 such places)")));
}

TEST_F(LogClock, BeginsANewRunIfTheClockIsSetBackByLessThanTheRun) {
  const Dataset data = load(plain_config(), log_of([](int k) { return printed(0.01 * k - (k < 250 ? 0.0 : 0.3)); }));
  ASSERT_EQ(data.trajectories.size(), 2u);
  EXPECT_EQ(data.trajectories[1].samples(), 350);
}

TEST_F(LogClock, KeepsTheFirstRowOfARepeatedStamp) {
  const Dataset data = load(plain_config(), log_of([](int k) { return printed(0.01 * (k % 200 == 5 ? k - 1 : k)); }));
  ASSERT_EQ(data.trajectories.size(), 1u);
  ASSERT_EQ(data.trajectories[0].samples(), 597);
  EXPECT_EQ(data.trajectories[0].outputs(0, 4), 4.0);
  EXPECT_EQ(data.trajectories[0].outputs(0, 5), 6.0);
  EXPECT_NEAR(data.trajectories[0].time_s[5], 0.06, 1e-9);
  EXPECT_THAT(report_.notes, ElementsAre(HasSubstr("log.csv:7: the stamp 0.040 equals that of the row before: only "
                                                   "the first of these rows is kept (the first of 3 such rows)")));
}

TEST_F(LogClock, RefusesStampsTooCoarseForTheRowsButNotRowsWrittenTwice) {
  EXPECT_THAT(error_in(plain_config(), log_of([](int k) { return printed(0.01 * (k / 4)); })),
              AllOf(HasSubstr("log.csv:3:time: 75 % of the rows have the stamp of the row before but other readings"),
                    HasSubstr("write [log] sample_period_s")));
  std::string twice = "time,y\n";
  for (int k = 0; k < 300; ++k)
    for (int copy = 0; copy < 2; ++copy) twice += printed(0.01 * k) + "," + std::to_string(k) + "\n";
  EXPECT_EQ(load(plain_config(), twice).trajectories[0].samples(), 300);
}

TEST_F(LogClock, LeavesOutRowsWhoseStampDoesNotFitItsNeighbours) {
  for (const double wrong : {0.0, 77.7}) {
    const Dataset data = load(plain_config(), log_of([&](int k) { return printed(k == 300 ? wrong : 0.01 * k); }));
    ASSERT_EQ(data.trajectories.size(), 1u) << wrong;
    EXPECT_EQ(data.trajectories[0].samples(), 599);
    EXPECT_EQ(data.trajectories[0].outputs(0, 300), 301.0);
    EXPECT_NEAR(data.trajectories[0].time_s[300], 3.01, 1e-9);
    EXPECT_THAT(report_.notes, ElementsAre(HasSubstr("log.csv:302: the stamp " + printed(wrong) +
                                                     " does not fit its neighbours: the row is left out")));
  }
  for (const int end : {0, 599})
    EXPECT_EQ(load(plain_config(), log_of([&](int k) { return printed(k == end ? (k == 0 ? 9.0 : 0.0) : 0.01 * k); }))
                  .trajectories[0]
                  .samples(),
              599);
}

TEST_F(LogClock, ReadsDatesAndTimesOfDayAlsoAcrossMidnight) {
  const auto clock = [](const char* format, int start_s) {
    return [=](int k) {
      const int ms = 10 * k + 7, s = start_s + ms / 1000;
      char text[64];
      std::snprintf(text, sizeof text, format, s / 3600 % 24, s / 60 % 60, s % 60, ms % 1000);
      return std::string(text);
    };
  };
  constexpr int kNoon_s = 12 * 3600 - 2, kMidnight_s = 24 * 3600 - 2;
  for (const auto& stamp :
       {clock("2026-11-20T%02d:%02d:%02d.%03dZ", kNoon_s), clock("2026-11-20 %02d:%02d:%02d.%03d+01:00", kNoon_s),
        clock("%02d:%02d:%02d.%03d", kNoon_s), clock("%d:%02d:%02d.%03d", kMidnight_s)}) {
    const Dataset data = load(plain_config(), log_of(stamp));
    ASSERT_EQ(data.trajectories.size(), 1u) << stamp(0);
    EXPECT_NEAR(data.sample_period_s, 0.01, 1e-9) << stamp(0);
    EXPECT_NEAR(data.trajectories[0].time_s[599], 5.99, 1e-9) << stamp(0);
    EXPECT_TRUE(report_.notes.empty()) << report_.notes[0];
  }
  EXPECT_THAT(error_in(plain_config(), log_of([](int k) {
                         return k == 3 ? std::string("10:11") : "10:11:12." + std::to_string(100 + k);
                       })),
              HasSubstr("log.csv:5:time: \"10:11\" is not a time in the format of the first one, \"10:11:12.100\""));
  EXPECT_THAT(error_in(plain_config(), log_of([](int) { return std::string("20.11.2026 10:11:12"); })),
              HasSubstr("2026-11-20T10:11:12.345Z"));
}

TEST_F(LogClock, ContinuesAfterTheOverflowOfACounter) {
  LogConfig config = plain_config();
  config.columns[0].unit = "us";
  const Dataset data =
      load(config, log_of([](int k) {
             return std::to_string((4294000000ull + 10000ull * static_cast<unsigned long long>(k)) % 4294967296ull);
           }));
  ASSERT_EQ(data.trajectories.size(), 1u);
  EXPECT_NEAR(data.trajectories[0].time_s[599], 5.99, 1e-9);
  EXPECT_TRUE(report_.notes.empty());
}

TEST(ClockText, ParsesTimesAndRefusesOtherTexts) {
  const auto seconds = [](const char* text) { return read_clock_text(text)->seconds; };
  EXPECT_EQ(seconds("10:11:12"), 36672.0);
  EXPECT_EQ(seconds(" 110:00:00,5 "), 396000.5);
  EXPECT_EQ(seconds("2026-11-20T10:11:12.25+01:00"), 33072.25);
  EXPECT_EQ(seconds("2026/11/20 10:11"), 36660.0);
  EXPECT_EQ(read_clock_text("1970-01-03 00:00:00")->day, 2);
  for (const char* none : {"", "1.5", "10:11", "10:61:00", "10:11:12.", "2026-13-01T00:00:00", "2026-02-30 00:00:00",
                           "20.11.2026 10:11:12", "10:11:12x", "2026-11-20", "10:11:12+1", "-1:00:00"})
    EXPECT_FALSE(read_clock_text(none)) << none;
}

/// Removes the rows `from` to `to` - 1.
std::string without_rows(const std::string& csv, int from, int to) {
  std::istringstream lines(csv);
  std::string text;
  int row = -1;  // the header
  for (std::string line; std::getline(lines, line); ++row)
    if (row < from || row >= to) text += line + "\n";
  return text;
}

TEST_F(LogClock, SplitsALogAtItsGaps) {
  const Dataset data = load(SyntheticLog::config(), without_rows(log_.csv(), 250, 300));  // 0.25 s
  ASSERT_EQ(data.trajectories.size(), 2u);
  EXPECT_TRUE(data.uniform);
  const Trajectory& second = data.trajectories[1];
  EXPECT_EQ(data.trajectories[0].source, "log.csv (1 of 2)");
  EXPECT_EQ(second.source, "log.csv (2 of 2)");
  EXPECT_EQ(data.trajectories[0].samples(), 250);
  ASSERT_EQ(second.samples(), 300);
  EXPECT_EQ(second.time_s[0], 0.0);
  EXPECT_LE(std::abs(second.outputs(0, 0)), 0.5 * kTurn);  // whole turns are counted from the start of the run
  for (int k = 0; k < 300; ++k) {
    const bool edge = second.time_s[k] < 0.2 || second.time_s[k] > second.time_s[299] - 0.2;
    ASSERT_EQ(second.weight[k], edge ? 0.0 : 1.0);
    if (edge) continue;
    ASSERT_NEAR(second.states(0, k), SyntheticLog::velocity(log_.time_s(300 + k)), 1e-3);  // as in a log without a gap
  }
  EXPECT_THAT(report_.notes, ElementsAre(AllOf(HasSubstr("log.csv:252: a gap of 0.2"), HasSubstr("split into 2 runs"),
                                               HasSubstr("[log] max_gap_s, now 0.05 s"))));
  ASSERT_EQ(report_.files.size(), 1u);  // one log
  EXPECT_EQ(report_.files[0].runs, 2u);
  EXPECT_EQ(report_.files[0].samples, 550);
  EXPECT_LT(report_.files[0].max_s, 0.01);  // the gap is not a step of either run
  EXPECT_THAT(to_text(report_), HasSubstr("log.csv (2 runs)      550"));
}

TEST_F(LogClock, KeepsALogWithAllowedGapsWhole) {
  LogConfig config = SyntheticLog::config();
  config.max_gap_s = 0.3;
  const Dataset data = load(config, without_rows(log_.csv(), 250, 300));
  ASSERT_EQ(data.trajectories.size(), 1u);
  EXPECT_EQ(data.trajectories[0].source, "log.csv");
  EXPECT_FALSE(data.uniform);  // one step is 51 periods
  EXPECT_TRUE(report_.notes.empty());
}

TEST_F(LogClock, DropsRunsThatAreTooShort) {
  const std::string csv = without_rows(without_rows(log_.csv(), 310, 360), 250, 300);  // 10 samples between two gaps
  const Dataset data = load(SyntheticLog::config(), csv);
  ASSERT_EQ(data.trajectories.size(), 2u);
  EXPECT_EQ(data.trajectories[1].source, "log.csv (3 of 3)");
  EXPECT_THAT(
      report_.notes,
      ElementsAre(HasSubstr("split into 3 runs"),
                  AllOf(HasSubstr("1 of its 3 runs cannot be used and are dropped, the first is log.csv (2 of 3)"),
                        HasSubstr("samples are too few"))));
  LogConfig config = SyntheticLog::config();
  config.velocity_filter.mask_edges_s = 1.0;
  EXPECT_THAT(error_in(config, csv), AllOf(HasSubstr("log.csv: none of its runs between gaps can be used"),
                                           HasSubstr("raise [log] max_gap_s")));
}

TEST_F(LogClock, ReplacesRoundedStampsByARegularGrid) {
  std::string csv = "time,phi\n";
  for (int k = 0; k < 800; ++k) {
    char row[64];
    std::snprintf(row, sizeof row, "%.3f,%.9g\n", 7.1 + 0.0025 * k,
                  std::remainder(SyntheticLog::angle(0.0025 * k), kTurn));
    csv += row;
  }
  LogConfig config = SyntheticLog::config();
  config.sample_period_s = 0.0;
  const Dataset data = load(config, csv);
  EXPECT_TRUE(data.uniform);
  EXPECT_NEAR(data.sample_period_s, 0.0025, 1.5e-3 / 800);  // largest effect of rounding to 1 ms over 800 samples
  EXPECT_TRUE(report_.files[0].nominal);
  const Trajectory& run = data.trajectories[0];
  for (int k = 100; k < 700; ++k) {
    ASSERT_NEAR(run.time_s[k], 0.0025 * k, 2.5e-4);
    // Rounding by half a millisecond at 7 rad/s would give 3.5 mrad of noise in the angle, and 0.2 rad/s in its
    // velocity.
    ASSERT_NEAR(run.states(0, k), SyntheticLog::velocity(0.0025 * k), 5e-3);
  }
}

constexpr double kTimeRounding = 1e-12;

TEST(TimeStamps, ReportsMedianTailsAndGaps) {
  Eigen::VectorXd time(201);
  time[0] = 0.0;
  for (int k = 1; k <= 200; ++k)
    time[k] = time[k - 1] + (k == 50 ? 0.008 : k == 70 ? 0.005 : k % 40 == 0 ? 0.003 : 0.004);
  const TimeStampReport report = report_time_stamps("run.csv", {time}, 0.004);
  EXPECT_EQ(report.samples, 201);
  EXPECT_NEAR(report.duration_s, time[200], kTimeRounding);
  EXPECT_NEAR(report.median_s, 0.004, kTimeRounding);
  EXPECT_NEAR(report.p01_s, 0.003, kTimeRounding);
  EXPECT_NEAR(report.p99_s, 0.004, kTimeRounding);
  EXPECT_NEAR(report.max_s, 0.008, kTimeRounding);
  EXPECT_EQ(report.gaps, 1);
}

/// t_k = 3.2 + k T + jitter, rounded to `digits` decimals.
Eigen::VectorXd stamps(int samples, double period_s, double jitter_s, int digits) {
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> jitter(-jitter_s, jitter_s);
  Eigen::VectorXd time(samples);
  for (int k = 0; k < samples; ++k)
    time[k] = std::round((3.2 + k * period_s + jitter(engine)) * std::pow(10.0, digits)) / std::pow(10.0, digits);
  return time;
}

TimeGrid grid_of(const Eigen::VectorXd& time) {
  return fit_time_grid(time, stamp_resolution(time));
}

TEST(TimeStamps, AreRegularWithinTheirRounding) {
  // Steps of 7 and 8 ms for a period of 7.5 ms; 2 and 3 ms for 2.5 ms, where the median step is wrong by 20 %.
  for (const double period_s : {1.0 / 120.0, 0.0075, 0.0025, 1.0 / 300.0}) {
    const TimeGrid grid = grid_of(stamps(2000, period_s, 0.0, 3));
    EXPECT_TRUE(grid.regular && grid.rounded && grid.complete) << period_s;
    // The largest effect of rounding on least squares is 1.5 times 1 ms over 2000 samples.
    EXPECT_NEAR(grid.period_s, period_s, 1.5e-3 / 2000.0) << period_s;
  }
}

TEST(TimeStamps, AreIrregularIfTheyJitterBeyondTheirRounding) {
  EXPECT_FALSE(grid_of(stamps(2000, 0.008, 1.5e-3, 3)).regular);
  EXPECT_FALSE(grid_of(stamps(2000, 0.004, 0.8e-3, 9)).regular);  // a fifth of a period
}

TEST(TimeStamps, AreRegularWithASmallJitterButKeepTheirTimes) {
  const TimeGrid grid = grid_of(stamps(2000, 0.004, 0.24e-3, 9));  // 6 %, like the Qube
  EXPECT_TRUE(grid.regular);
  EXPECT_FALSE(grid.rounded);
}

TEST(TimeStamps, AreIrregularIfTheClockDrifts) {
  Eigen::VectorXd time(2000);  // no step is wrong by more than 0.3 %, but half a period is lost in between
  for (int k = 0; k < 2000; ++k) time[k] = 0.01 * (k + 0.5 * std::sin(6e-3 * k));
  EXPECT_FALSE(grid_of(time).regular);
}

TEST(TimeStamps, GridLeavesOutMissingSamples) {
  const Eigen::VectorXd all = stamps(2000, 0.0075, 0.0, 3);
  Eigen::VectorXd some(1997);
  some << all.head(700), all.segment(702, 298), all.tail(999);  // two missing samples in a row, and one
  const TimeGrid grid = grid_of(some);
  EXPECT_TRUE(grid.regular && grid.rounded);
  EXPECT_FALSE(grid.complete);
  EXPECT_NEAR(grid.period_s, 0.0075, 1e-6);
  EXPECT_EQ(grid.counts[700], 702.0);
  EXPECT_EQ(grid.counts[1996], 1999.0);
}

TEST(TimeStamps, HaveTheResolutionOfTheirDigits) {
  EXPECT_DOUBLE_EQ(stamp_resolution(stamps(100, 1.0 / 120.0, 0.0, 3)), 1e-3);
  EXPECT_DOUBLE_EQ(stamp_resolution(stamps(100, 1.0 / 120.0, 0.0, 6)), 1e-6);
  EXPECT_DOUBLE_EQ(stamp_resolution(Eigen::Vector4d(0, 8, 17, 25)), 1.0);
  EXPECT_DOUBLE_EQ(stamp_resolution(stamps(100, 1.0 / 120.0, 0.0, 3).array() + 1.7e9), 1e-3);  // seconds since 1970
  EXPECT_EQ(stamp_resolution(Eigen::Vector3d(0.0, std::sqrt(2.0), 3.0)), 0.0);
}

TEST(TimeStamps, PeriodsMayDifferByAThousandthAndByTheResolution) {
  const TimeGrid whole = grid_of(stamps(2000, 0.0075, 0.0, 3)), piece = grid_of(stamps(30, 0.0075, 0.0, 3));
  EXPECT_TRUE(has_period(whole, 0.0075));
  EXPECT_FALSE(has_period(whole, 0.0075 * 1.002));
  EXPECT_TRUE(has_period(piece, 0.0075 * 1.002));  // 30 samples with a resolution of 1 ms
  EXPECT_FALSE(has_period(piece, 0.008));
}

TEST(TimeStamps, MedianIsOverAllLogsTogether) {
  const Eigen::VectorXd slow = Eigen::VectorXd::LinSpaced(4, 0.0, 3.0), fast = Eigen::VectorXd::LinSpaced(11, 0.0, 1.0);
  EXPECT_NEAR(median_step({slow, fast}), 0.1, kTimeRounding);
}

}  // namespace
}  // namespace nlo::trainer
