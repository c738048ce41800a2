// SPDX-License-Identifier: MIT
#include "trainer/data/log_dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "tests/data/testing.h"

namespace nlo::trainer {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kPrinted = 1e-10;  // the synthetic log is written with 12 digits

class LogDataset : public ::testing::Test {
 protected:
  Dataset load(const LogConfig& config, const std::string& csv) {
    scratch_.write("log.csv", csv);
    return load_logs(config, scratch_.path(), {"log.csv"}, &report_);
  }
  std::string error_in(const LogConfig& config, const std::string& csv) {
    return error_of([&] { load(config, csv); });
  }

  ScratchDirectory scratch_;
  LogReport report_;
  SyntheticLog log_;
};

TEST_F(LogDataset, UnwrapsOutputsAndStartsTimeAtZero) {
  const Dataset data = load(SyntheticLog::config(), log_.csv());
  ASSERT_EQ(data.trajectories.size(), 1u);
  const Trajectory& run = data.trajectories[0];
  EXPECT_EQ(run.source, "log.csv");
  ASSERT_EQ(run.samples(), log_.samples);
  EXPECT_TRUE(data.uniform);  // 5 % of jitter
  EXPECT_EQ(data.sample_period_s, 0.005);
  EXPECT_EQ(data.outputs[0].unit, "rad");
  for (int k = 0; k < log_.samples; ++k) {
    ASSERT_NEAR(run.time_s[k], log_.time_s(k) - log_.time_s(0), kPrinted);
    ASSERT_NEAR(run.outputs(0, k), SyntheticLog::angle(log_.time_s(k)), kPrinted);
  }
  EXPECT_GT(run.outputs.maxCoeff(), 0.5 * kTurn);  // control: the angle does wrap in this log
}

TEST_F(LogDataset, TakesVelocitiesWithoutDelayAndMasksTheEdges) {
  const Dataset data = load(SyntheticLog::config(), log_.csv());
  const Trajectory& run = data.trajectories[0];
  const double end_s = run.time_s[run.samples() - 1];
  for (int k = 0; k < log_.samples; ++k) {
    const bool edge = run.time_s[k] < 0.2 || run.time_s[k] > end_s - 0.2;
    ASSERT_EQ(run.weight[k], edge ? 0.0 : 1.0);
    if (edge) continue;
    ASSERT_NEAR(run.states(0, k), SyntheticLog::velocity(log_.time_s(k)), 1e-3);  // as ZeroPhaseVelocity
  }
}

TEST_F(LogDataset, CountsEverySampleWhereNoFilterRan) {
  LogConfig config = SyntheticLog::config();
  config.columns[2] = column("angle", ColumnRole::kState, {.column = "phi", .wrap = kTurn});
  const Dataset data = load(config, log_.csv());
  EXPECT_EQ(data.trajectories[0].weight.sum(), log_.samples);
  EXPECT_EQ(data.trajectories[0].states, data.trajectories[0].outputs);  // one column, both output and state
}

TEST_F(LogDataset, EncodesAnglesAsSineAndCosine) {
  LogConfig config = SyntheticLog::config();
  config.columns[1].encoding = Encoding::kSincos;
  const Dataset data = load(config, log_.csv());
  const Trajectory& run = data.trajectories[0];
  ASSERT_EQ(run.outputs.rows(), 2);
  for (int k = 0; k < log_.samples; ++k) {
    ASSERT_NEAR(run.outputs(0, k), std::sin(SyntheticLog::angle(log_.time_s(k))), kPrinted);
    ASSERT_NEAR(run.outputs(1, k), std::cos(SyntheticLog::angle(log_.time_s(k))), kPrinted);
  }
  EXPECT_NEAR(run.states(0, 300), SyntheticLog::velocity(log_.time_s(300)), 1e-3);  // of the angle, not of its sine
}

TEST_F(LogDataset, TakesThePeriodOfTheStampsWhenNoneIsGiven) {
  LogConfig config = SyntheticLog::config();
  config.sample_period_s = 0.0;
  EXPECT_NEAR(load(config, log_.csv()).sample_period_s, 0.005, 1e-6);  // 5 % of jitter, 600 samples
  EXPECT_EQ(report_.sample_period_s, load(config, log_.csv()).sample_period_s);
}

TEST_F(LogDataset, IsUniformWithoutTimeStamps) {
  LogConfig config = SyntheticLog::config();
  config.columns.erase(config.columns.begin());
  const Dataset data = load(config, log_.csv());
  EXPECT_TRUE(data.uniform);
  EXPECT_NEAR(data.trajectories[0].time_s[100], 0.5, kPrinted);
}

TEST_F(LogDataset, ReadsTimeInMilliseconds) {
  LogConfig config = SyntheticLog::config();
  config.columns[0].unit = "ms";
  EXPECT_THAT(error_in(config, log_.csv()),
              AllOf(HasSubstr("the median step is"), HasSubstr("unit of the time column")));
  config.sample_period_s = 0.0;
  config.velocity_filter.cutoff_hz = 2e4;
  config.velocity_filter.mask_edges_s = 2e-4;
  EXPECT_NEAR(load(config, log_.csv()).sample_period_s, 5e-6, 0.1 * 5e-6);
}

/// Without rows `from` to `to` - 1.
std::string without_rows(const std::string& csv, int from, int to) {
  std::istringstream lines(csv);
  std::string text;
  int row = -1;  // the header
  for (std::string line; std::getline(lines, line); ++row)
    if (row < from || row >= to) text += line + "\n";
  return text;
}

TEST_F(LogDataset, SplitsALogAtItsGaps) {
  const Dataset data = load(SyntheticLog::config(), without_rows(log_.csv(), 250, 300));  // 0.25 s
  ASSERT_EQ(data.trajectories.size(), 2u);
  EXPECT_TRUE(data.uniform);
  const Trajectory& second = data.trajectories[1];
  EXPECT_EQ(data.trajectories[0].source, "log.csv (1 of 2)");
  EXPECT_EQ(second.source, "log.csv (2 of 2)");
  EXPECT_EQ(data.trajectories[0].samples(), 250);
  ASSERT_EQ(second.samples(), 300);
  EXPECT_EQ(second.time_s[0], 0.0);
  EXPECT_LE(std::abs(second.outputs(0, 0)), 0.5 * kTurn);  // whole turns are counted from its start
  for (int k = 0; k < 300; ++k) {
    const bool edge = second.time_s[k] < 0.2 || second.time_s[k] > second.time_s[299] - 0.2;
    ASSERT_EQ(second.weight[k], edge ? 0.0 : 1.0);
    if (edge) continue;
    ASSERT_NEAR(second.states(0, k), SyntheticLog::velocity(log_.time_s(300 + k)), 1e-3);  // as without a gap
  }
  EXPECT_THAT(report_.notes, ElementsAre(AllOf(HasSubstr("log.csv:252: a gap of 0.2"), HasSubstr("split into 2 runs"),
                                               HasSubstr("[log] max_gap_s, now 0.05 s"))));
  EXPECT_EQ(report_.files.size(), 2u);
}

TEST_F(LogDataset, KeepsALogWholeWhoseGapsAreAllowed) {
  LogConfig config = SyntheticLog::config();
  config.max_gap_s = 0.3;
  const Dataset data = load(config, without_rows(log_.csv(), 250, 300));
  ASSERT_EQ(data.trajectories.size(), 1u);
  EXPECT_EQ(data.trajectories[0].source, "log.csv");
  EXPECT_FALSE(data.uniform);  // one step is 51 periods
  EXPECT_TRUE(report_.notes.empty());
}

TEST_F(LogDataset, DropsRunsThatAreTooShort) {
  const std::string csv = without_rows(without_rows(log_.csv(), 310, 360), 250, 300);  // 10 samples between two gaps
  const Dataset data = load(SyntheticLog::config(), csv);
  ASSERT_EQ(data.trajectories.size(), 2u);
  EXPECT_EQ(data.trajectories[1].source, "log.csv (3 of 3)");
  EXPECT_THAT(report_.notes,
              ElementsAre(HasSubstr("split into 3 runs"), AllOf(HasSubstr("too short, and dropped: log.csv (2 of 3)"),
                                                                HasSubstr("samples are too few"))));
  LogConfig config = SyntheticLog::config();
  config.velocity_filter.mask_edges_s = 1.0;
  EXPECT_THAT(error_in(config, csv),
              AllOf(HasSubstr("log.csv: no run between its gaps can be used"), HasSubstr("raise [log] max_gap_s")));
}

TEST_F(LogDataset, TakesTheGridForRoundedStamps) {
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
  EXPECT_NEAR(data.sample_period_s, 0.0025, 1.5e-3 / 800);  // the worst of 1 ms over 800 samples
  EXPECT_TRUE(report_.files[0].nominal);
  const Trajectory& run = data.trajectories[0];
  for (int k = 100; k < 700; ++k) {
    ASSERT_NEAR(run.time_s[k], 0.0025 * k, 2.5e-4);
    // Half a millisecond at 7 rad/s would be 3.5 mrad of noise in the angle, and 0.2 rad/s in its velocity.
    ASSERT_NEAR(run.states(0, k), SyntheticLog::velocity(0.0025 * k), 5e-3);
  }
}

TEST_F(LogDataset, EveryNthRowKeepsTheVelocityOfAllRows) {
  LogConfig config = SyntheticLog::config();
  const Dataset all = load(config, log_.csv());
  config.every = 5;
  config.sample_period_s = 5.0 * all.sample_period_s;
  const Dataset thin = load(config, log_.csv());
  EXPECT_DOUBLE_EQ(thin.sample_period_s, 5.0 * all.sample_period_s);
  EXPECT_EQ(thin.uniform, all.uniform);
  const Trajectory &run = thin.trajectories[0], &whole = all.trajectories[0];
  ASSERT_EQ(run.samples(), (whole.samples() + 4) / 5);
  for (Eigen::Index k = 0; k < run.samples(); ++k) {
    ASSERT_NEAR(run.time_s(k), whole.time_s(5 * k), 1e-12);
    ASSERT_EQ(run.outputs.col(k), whole.outputs.col(5 * k));
    ASSERT_EQ(run.states.col(k), whole.states.col(5 * k));
    ASSERT_EQ(run.weight(k), whole.weight(5 * k));
  }
}

TEST_F(LogDataset, ReadsInputsAndChecksThem) {
  LogConfig config = SyntheticLog::config();
  config.columns.push_back(column("torque", ColumnRole::kInput));
  config.columns.back().odd = false;
  const Dataset data = load(config, log_.csv());
  EXPECT_TRUE(data.reads_inputs);
  ASSERT_EQ(data.readings().size(), data.outputs.size() + 1);
  EXPECT_EQ(data.readings().back().name, "torque");
  EXPECT_EQ(data.mirror.input(0), 1.0);
  const Trajectory& run = data.trajectories[0];
  ASSERT_EQ(run.inputs.rows(), 1);
  ASSERT_EQ(run.inputs.cols(), run.samples());
  EXPECT_GT(run.inputs.cwiseAbs().maxCoeff(), 0.0);
  config.columns.back().column = "comment";
  EXPECT_THAT(error_in(config, log_.csv()), HasSubstr("log.csv:2:comment: \"row, 0\" is not a number"));
}

TEST_F(LogDataset, NotesAnAngleThatWasNotDeclared) {
  LogConfig config = SyntheticLog::config();
  load(config, log_.csv());
  EXPECT_TRUE(report_.notes.empty());  // control
  config.columns[1].wrap = 0.0;
  load(config, log_.csv());
  EXPECT_THAT(report_.notes,
              ElementsAre(AllOf(HasSubstr("\"phi\" jumps by more than half a turn"), HasSubstr("give its wrap"))));
}

TEST_F(LogDataset, ReportsTheClockOfEachFile) {
  load(SyntheticLog::config(), log_.csv());
  ASSERT_EQ(report_.files.size(), 1u);
  EXPECT_EQ(report_.files[0].samples, log_.samples);
  EXPECT_EQ(report_.data_hash.size(), 16u);
  EXPECT_THAT(to_text(report_), AllOf(HasSubstr("nominal sample period 5 ms"), HasSubstr("log.csv")));
}

TEST_F(LogDataset, NamesTheLineWhereTimeStandsStill) {
  EXPECT_THAT(error_in(SyntheticLog::config(), "time,phi\n1,0\n2,0\n2,0\n"),
              HasSubstr("log.csv:4:time: time does not increase: 2 follows 2"));
  EXPECT_THAT(error_in(SyntheticLog::config(), "time,phi\n2,0\n1,0\n"),
              HasSubstr("log.csv:3:time: time does not increase"));
}

TEST_F(LogDataset, RefusesLogsThatAreTooShort) {
  const LogConfig config = SyntheticLog::config();
  EXPECT_THAT(error_in(config, "time,phi\n1,0\n"), HasSubstr("at least two samples"));
  EXPECT_THAT(error_in(config, "time,phi\n1,0\n1.005,0\n1.01,0\n"),
              AllOf(HasSubstr("log.csv: "), HasSubstr("samples are too few")));
  log_.samples = 60;  // 0.3 s
  EXPECT_THAT(error_in(config, log_.csv()), HasSubstr("within mask_edges_s = 0.2 s of its ends"));
  EXPECT_THAT(error_of([&] { load_logs(config, scratch_.path(), {}); }), HasSubstr("no logs are named"));
}

TEST_F(LogDataset, NamesAFileWithoutTheColumn) {
  LogConfig config = SyntheticLog::config();
  config.columns[1].column = "psi";
  EXPECT_THAT(error_in(config, log_.csv()), HasSubstr("log.csv:1: no column \"psi\" among comment, phi, torque, time"));
}

TEST_F(LogDataset, LoadsSplitsOnTheClockOfTheTrainingLogs) {
  LogConfig config = SyntheticLog::config();
  config.sample_period_s = 0.0;
  scratch_.write("a.csv", log_.csv());
  log_.samples = 500;
  scratch_.write("b.csv", log_.csv());
  log_.samples = 400;
  log_.period_s = 0.006;
  scratch_.write("c.csv", log_.csv());
  config.train_files = {"[ab].csv"};
  config.test_files = {"c.csv"};
  const LogSplits splits = load_log_splits(config, scratch_.path());
  EXPECT_EQ(splits.train.trajectories.size(), 2u);
  EXPECT_TRUE(splits.validation.trajectories.empty());
  EXPECT_EQ(splits.validation.states.size(), 1u);
  ASSERT_EQ(splits.test.trajectories.size(), 1u);
  EXPECT_EQ(splits.test.trajectories[0].source, "c.csv");
  EXPECT_EQ(splits.test.sample_period_s, splits.train.sample_period_s);
  EXPECT_EQ(splits.report.sample_period_s, splits.train.sample_period_s);
  EXPECT_EQ(splits.report.files.size(), 3u);
}

TEST_F(LogDataset, TakesThePeriodOfTheRowsTimesEvery) {
  LogConfig config = SyntheticLog::config();
  config.every = 4;
  config.sample_period_s = 0.0;
  EXPECT_NEAR(load(config, log_.csv()).sample_period_s, 0.02, 1e-5);  // jitter at the ends of the log
}

TEST_F(LogDataset, TrainsOnEveryRowThoughTheObserverIsGivenEachNth) {
  LogConfig config = SyntheticLog::config();
  config.every = 7;
  config.sample_period_s *= 7;
  for (const char* name : {"train.csv", "test.csv"}) {
    scratch_.write(name, log_.csv());
    log_.samples = 500;
  }
  config.train_files = {"train.csv"};
  config.test_files = {"test.csv"};
  const LogSplits splits = load_log_splits(config, scratch_.path());
  ASSERT_EQ(splits.train.trajectories.size(), 7u);
  EXPECT_EQ(splits.train.trajectories[0].source, "train.csv");
  EXPECT_EQ(splits.train.trajectories[2].source, "train.csv from its row 3");
  Eigen::Index rows = 0;
  for (const Trajectory& run : splits.train.trajectories) {
    EXPECT_EQ(run.time_s[0], 0.0);
    rows += run.samples();
  }
  EXPECT_EQ(rows, 600);
  ASSERT_EQ(splits.test.trajectories.size(), 1u);
  EXPECT_EQ(splits.test.trajectories[0].samples(), 72);
  EXPECT_EQ(splits.test.sample_period_s, splits.train.sample_period_s);
}

TEST_F(LogDataset, RefusesToLeaveTooFewRows) {
  LogConfig config = SyntheticLog::config();
  config.every = 600;
  config.sample_period_s *= 600;
  EXPECT_THAT(error_in(config, log_.csv()), HasSubstr("log.csv: 600 rows, and every = 600 leaves no two samples"));
}

}  // namespace
}  // namespace nlo::trainer
