// SPDX-License-Identifier: MIT
// The loader on logs of two real rigs, which are not part of this project. The figures come from the written protocol
// for these rigs, or were measured once with this code.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "tests/data/data_testing.h"
#include "trainer/data/csv.h"
#include "trainer/data/log_baselines.h"
#include "trainer/data/log_dataset.h"
#include "trainer/data/log_metrics.h"

namespace nlo::trainer {
namespace {

constexpr std::size_t kAll = 0, kAfter2s = 1;
const EvaluationWindows kLogWindows = {{"all", 0.0, 1e300}, {"after_2_s", 2.0, 1e300}};

class RealLogs : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::is_directory(NLO_SHARED_DATA_DIR))
      GTEST_SKIP() << "the logs of the real rigs are not at " << NLO_SHARED_DATA_DIR;
  }

  static std::string directory(const std::string& rig) { return std::string(NLO_SHARED_DATA_DIR) + "/" + rig; }

  static LogConfig qube() {
    LogConfig log;
    log.columns = {column("time", ColumnRole::kTime, {.unit = "s"}),
                   column("theta", ColumnRole::kOutput, {.unit = "rad"}),
                   column("alpha", ColumnRole::kOutput, {.unit = "rad", .wrap = kTurn}),
                   column("theta_velocity", ColumnRole::kState, {.unit = "rad/s", .derivative_of = "theta"}),
                   column("alpha_velocity", ColumnRole::kState, {.unit = "rad/s", .derivative_of = "alpha"})};
    log.train_files = {"example_csv_fin[1-6].csv"};
    log.validation_files = {"example_csv_fin7.csv"};
    log.test_files = {"example_csv_fin8.csv"};
    return log;
  }

  static LogConfig double_pendulum() {
    LogConfig log;
    log.columns = {column("time", ColumnRole::kTime, {.unit = "s"}),
                   column("pos1", ColumnRole::kOutput, {.column = "pos_meas1", .unit = "rad"}),
                   column("pos2", ColumnRole::kOutput, {.column = "pos_meas2", .unit = "rad"}),
                   column("vel1", ColumnRole::kState, {.unit = "rad/s", .derivative_of = "pos1"}),
                   column("vel2", ColumnRole::kState, {.unit = "rad/s", .derivative_of = "pos2"})};
    log.velocity_filter.cutoff_hz = 20.0;
    log.train_files = {"trajectory_0[0-2].csv"};
    log.test_files = {"trajectory_03.csv"};
    return log;
  }
};

TEST_F(RealLogs, QubeAnglesHaveNoJumpsAndAClockOfFourMilliseconds) {
  const LogSplits splits = load_log_splits(qube(), directory("qube"));
  EXPECT_EQ(splits.train.trajectories.size(), 6u);
  EXPECT_NEAR(splits.train.sample_period_s, 0.004, 1e-6);
  const auto further = ::testing::HasSubstr("output \"theta\" leaves its training range");
  EXPECT_THAT(splits.report.notes, ::testing::ElementsAre(further, further));  // the arm drifts in logs 7 and 8
  EXPECT_TRUE(splits.train.uniform && splits.validation.uniform && splits.test.uniform);  // jitter within 6 %
  for (const TimeStampReport& file : splits.report.files) {
    EXPECT_EQ(file.gaps, 0) << file.file;
    EXPECT_LT(file.max_s, 1.1 * 0.004) << file.file;
  }
  for (const Trajectory& run : splits.train.trajectories) {
    const Eigen::Index n = run.samples();
    // 30 rad/s over 4 ms: the pendulum is not faster.
    EXPECT_LT((run.outputs.rightCols(n - 1) - run.outputs.leftCols(n - 1)).cwiseAbs().maxCoeff(), 0.12) << run.source;
  }
}

TEST_F(RealLogs, NotesAnImpossibleSpeedOfTheCarAndNothingInOrdinaryLogs) {
  const auto outliers = [](const std::string& rig, const std::string& files, std::vector<ColumnConfig> columns) {
    LogConfig log;
    log.columns = std::move(columns);
    LogReport report;
    load_logs(log, directory(rig), {files}, &report);
    std::vector<std::string> found;
    for (const std::string& note : report.notes)
      if (note.find("an outlier") != std::string::npos) found.push_back(note);
    return found;
  };
  const ColumnConfig time = column("time", ColumnRole::kTime, {.unit = "s"});
  const auto measured = [](const char* name) { return column(name, ColumnRole::kOutput); };
  const auto truth = [](const char* name) { return column(name, ColumnRole::kState, {.unit = "m/s"}); };
  // The log has two outliers: v_x of 10.33 m/s in one row and v_y of -2 m/s in the next.
  using ::testing::ElementsAre, ::testing::HasSubstr, ::testing::IsEmpty;
  const std::vector<ColumnConfig> car = {time, measured("yaw_rate"), truth("v_x"), truth("v_y")};
  EXPECT_THAT(outliers("car", "rubber_01.csv", car),
              ElementsAre(HasSubstr("rubber_01.csv:1613: \"v_x\" is 10.33 m/s"),
                          HasSubstr("rubber_01.csv:1614: \"v_y\" is -2.006 m/s")));
  EXPECT_THAT(outliers("car", "*_*.csv", car),
              ElementsAre(HasSubstr("rubber_01.csv:1613: \"v_x\""), HasSubstr("rubber_01.csv:1614: \"v_y\"")));
  for (const char* quiet : {"fast_0?.csv", "free_0?.csv", "rubber_0[35689].csv", "rubber_1?.csv", "steer_01.csv"})
    EXPECT_THAT(outliers("car", quiet, car), IsEmpty()) << quiet;
  EXPECT_THAT(outliers("battery", "*.csv", {time, measured("voltage"), column("soc", ColumnRole::kState)}), IsEmpty());
  EXPECT_THAT(
      outliers("double_pendulum", "*.csv", {time, measured("pos_meas1"), truth("vel_filt1"), truth("vel_filt2")}),
      IsEmpty());
  EXPECT_THAT(outliers("broad", "*.csv", {time, measured("gyr_x"), truth("up_x"), truth("up_y"), truth("up_z")}),
              IsEmpty());
}

TEST_F(RealLogs, QubeLoggedVelocitiesLagBehindTheTruth) {
  const Dataset data = load_logs(qube(), directory("qube"), {"*.csv"});
  std::vector<Eigen::MatrixXd> logged;
  for (const Trajectory& run : data.trajectories) {
    const CsvTable table = CsvTable::read(directory("qube") + "/" + run.source);
    Eigen::MatrixXd velocity(2, run.samples());
    velocity << table.column("theta_dot").transpose(), table.column("alpha_dot").transpose();
    logged.push_back(velocity);
  }
  // The protocol has 0.54 and 0.99 rad/s; other reasonable smoothers and masks differ by about 5 %.
  const LogMetrics metrics = log_metrics(data, logged);
  EXPECT_NEAR(metrics.pooled[0].rmse[kAll], 0.54, 0.05 * 0.54);
  EXPECT_NEAR(metrics.pooled[1].rmse[kAll], 0.99, 0.05 * 0.99);
}

TEST_F(RealLogs, DetectsTheLagOfLoggedQubeVelocities) {
  using ::testing::HasSubstr;
  LogConfig config = qube();
  config.columns[3] = column("theta_dot", ColumnRole::kState, {.unit = "rad/s"});
  config.columns[4] = column("alpha_dot", ColumnRole::kState, {.unit = "rad/s"});
  const auto late = [](const char* state, const char* output) {
    return ::testing::AllOf(HasSubstr(std::string("\"") + state + "\" is the velocity of \"" + output + "\", 4."),
                            HasSubstr("samples late"));
  };
  config.validation_files = config.test_files = {};
  EXPECT_THAT(load_log_splits(config, directory("qube")).report.notes,
              ::testing::ElementsAre(late("theta_dot", "theta"), late("alpha_dot", "alpha")));
}

TEST_F(RealLogs, QubeBaselinesHaveTheKnownOrder) {
  const LogConfig config = qube();
  const LogSplits splits = load_log_splits(config, directory("qube"));
  const auto rmse = [&](const char* name) {
    const LogBaseline baseline = LogBaseline::fit(name, splits.train, resolve_columns(config).state_sources);
    return log_metrics(splits.test, {baseline.estimate(splits.test.trajectories[0])}, {}, kLogWindows).pooled;
  };
  const auto constant = rmse("constant"), difference = rmse("difference"), polynomial = rmse("polynomial");
  for (std::size_t i = 0; i < 2; ++i)
    for (const std::size_t window : {kAll, kAfter2s}) {
      EXPECT_LT(polynomial[i].rmse[window], 0.6 * difference[i].rmse[window]);
      EXPECT_LT(difference[i].rmse[window], 0.3 * constant[i].rmse[window]);
    }
}

TEST_F(RealLogs, DoublePendulumLoadsWithItsGaps) {
  const LogSplits splits = load_log_splits(double_pendulum(), directory("double_pendulum"));
  EXPECT_NEAR(splits.train.sample_period_s, 0.002, 1e-5);
  int gaps = 0;
  for (const TimeStampReport& file : splits.report.files) gaps += file.gaps;
  EXPECT_EQ(gaps, 8 + 17 + 15 + 7);
  EXPECT_FALSE(splits.train.uniform);  // its pauses of 3 to 8 ms keep their time stamps
  EXPECT_EQ(splits.train.trajectories.size(), 3u);
  // The zero-phase velocity has no delay. The logged backward differences are noisier; both agree within their noise.
  const CsvTable table = CsvTable::read(directory("double_pendulum") + "/trajectory_03.csv");
  Eigen::MatrixXd logged(2, table.rows());
  logged << table.column("vel_meas1").transpose(), table.column("vel_meas2").transpose();
  const LogMetrics metrics = log_metrics(splits.test, {logged});
  EXPECT_LT(metrics.pooled[0].rmse[kAll], 0.3);
  EXPECT_LT(metrics.pooled[1].rmse[kAll], 0.3);
}

}  // namespace
}  // namespace nlo::trainer
