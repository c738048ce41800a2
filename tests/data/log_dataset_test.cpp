// SPDX-License-Identifier: MIT
#include "trainer/data/log_dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/data/data_testing.h"

namespace nlo::trainer {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

using LogDataset = LoadingLogs;

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

TEST_F(LogDataset, AComputedOutputIsMissingIfAChannelThatItReadsIsEmpty) {
  LogConfig config;
  config.sample_period_s = 0.1;
  ColumnConfig power = column("power", ColumnRole::kOutput);
  power.expression = "volt * amp - 1";
  config.columns = {column("volt", ColumnRole::kOutput), column("amp", ColumnRole::kInput), power,
                    column("x", ColumnRole::kState)};
  const Dataset data = load(config, "volt,amp,x\n1,2,0\n3,4,1\n,5,2\n6,7,3\n");
  ASSERT_EQ(data.outputs.size(), 2u);
  const Trajectory& run = data.trajectories[0];
  EXPECT_EQ(Eigen::RowVectorXd(run.outputs.row(1)), Eigen::RowVector4d(1.0, 11.0, 14.0, 41.0));
  ASSERT_EQ(run.missing.rows(), 2);
  EXPECT_TRUE(run.missing(1, 2));
  EXPECT_FALSE(run.missing(1, 3));
  EXPECT_EQ(data.sensors(), 1u);
}

TEST_F(LogDataset, ComputesVelocitiesWithoutDelayAndMasksTheEnds) {
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

TEST_F(LogDataset, ScoresEverySampleWithoutAFilter) {
  LogConfig config = SyntheticLog::config();
  config.columns[2] = column("angle", ColumnRole::kState, {.column = "phi", .wrap = kTurn});
  const Dataset data = load(config, log_.csv());
  EXPECT_EQ(data.trajectories[0].weight.sum(), log_.samples);
  EXPECT_EQ(data.trajectories[0].states, data.trajectories[0].outputs);  // one column is both output and state
}

TEST_F(LogDataset, ScoresTheTruthUnlessAMaskIsZeroOrEmpty) {
  LogConfig config;
  config.columns = {column("time", ColumnRole::kTime), column("a", ColumnRole::kOutput),
                    column("b", ColumnRole::kState), column("moving", ColumnRole::kMask),
                    column("seen", ColumnRole::kMask)};
  std::string text = "time,a,b,moving,seen\n";
  for (int k = 0; k < 100; ++k)
    text += std::to_string(0.01 * k) + ",1,2," + (k < 40 ? "0" : "1") + "," +
            (k < 70   ? "0.5"
             : k < 80 ? ""
                      : "0") +
            "\n";
  const Trajectory run = load(config, text).trajectories[0];
  for (int k = 0; k < 100; ++k) ASSERT_EQ(run.weight[k], k >= 40 && k < 70 ? 1.0 : 0.0) << k;
  for (std::size_t at = text.find(",1,0.5"); at != std::string::npos; at = text.find(",1,0.5", at)) text[at + 1] = '0';
  EXPECT_THAT(thrown_message([&] { (void)load(config, text); }), HasSubstr("role \"mask\""));
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
  EXPECT_NEAR(run.states(0, 300), SyntheticLog::velocity(log_.time_s(300)),
              1e-3);  // rate of the angle, not of its sine
}

TEST_F(LogDataset, VelocitiesOfEveryNthRowComeFromAllRows) {
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
  const Dataset data = load(config, log_.csv());
  EXPECT_TRUE(data.reads_inputs);
  ASSERT_EQ(data.readings().size(), data.outputs.size() + 1);
  EXPECT_EQ(data.readings().back().name, "torque");
  const Trajectory& run = data.trajectories[0];
  ASSERT_EQ(run.inputs.rows(), 1);
  ASSERT_EQ(run.inputs.cols(), run.samples());
  EXPECT_GT(run.inputs.cwiseAbs().maxCoeff(), 0.0);
  config.columns.back().column = "comment";
  EXPECT_THAT(error_in(config, log_.csv()), HasSubstr("log.csv:2:comment: \"row, 0\" is not a number"));
}

TEST_F(LogDataset, NotesAnUndeclaredAngle) {
  LogConfig config = SyntheticLog::config();
  load(config, log_.csv());
  EXPECT_TRUE(report_.notes.empty());  // control
  config.columns[1].wrap = 0.0;
  load(config, log_.csv());
  EXPECT_THAT(report_.notes, ElementsAre(AllOf(HasSubstr("\"phi\" jumps from 3."), HasSubstr("write wrap = \"2pi\""))));
}

TEST_F(LogDataset, RefusesLogsThatAreTooShort) {
  const LogConfig config = SyntheticLog::config();
  EXPECT_THAT(error_in(config, "time,phi\n1,0\n"), HasSubstr("at least two samples"));
  EXPECT_THAT(error_in(config, "time,phi\n1,0\n1.005,0\n1.01,0\n"),
              AllOf(HasSubstr("log.csv: "), HasSubstr("samples are too few")));
  log_.samples = 60;  // 0.3 s
  EXPECT_THAT(error_in(config, log_.csv()), HasSubstr("within mask_edges_s = 0.2 s of an end"));
  EXPECT_THAT(thrown_message([&] { load_logs(config, scratch_.path(), {}); }), HasSubstr("no log is named"));
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

TEST_F(LogDataset, TrainsOnAllOffsetsOfEveryNthRow) {
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

TEST_F(LogDataset, ConvertsCellsBeforeUnwrappingAndFiltering) {
  std::string csv = "time,phi\n";
  for (int k = 0; k < log_.samples; ++k) {
    char row[64];
    std::snprintf(row, sizeof row, "%.12g,%.12g\n", log_.time_s(k),
                  std::remainder(SyntheticLog::angle(log_.time_s(k)), kTurn) * 360.0 / kTurn);
    csv += row;
  }
  LogConfig config = SyntheticLog::config();
  const Dataset radians = load(config, log_.csv());
  config.columns[1].file_unit = "deg";
  const Dataset degrees = load(config, csv);
  EXPECT_TRUE(report_.notes.empty()) << report_.notes[0];
  EXPECT_TRUE(degrees.trajectories[0].outputs.isApprox(radians.trajectories[0].outputs, 1e-9));
  EXPECT_TRUE(degrees.trajectories[0].states.isApprox(radians.trajectories[0].states, 1e-7));
  EXPECT_EQ(degrees.outputs[0].unit, "rad");
  config = SyntheticLog::config();
  config.columns[1] = column("phi", ColumnRole::kOutput, {.unit = "deg", .wrap = 360.0});
  const Dataset velocity = load(config, csv);  // phi in deg, its velocity in rad/s
  EXPECT_TRUE(velocity.trajectories[0].states.isApprox(radians.trajectories[0].states, 1e-7));
  EXPECT_GT(velocity.trajectories[0].outputs.maxCoeff(), 180.0);
}

TEST_F(LogDataset, ReadsALogWithDecimalCommas) {
  std::string csv = log_.csv();
  std::string german =
      "# Pr\xC3\xBC"
      "fstand 2\n";
  bool quoted = false;
  for (const char c : csv) {
    if (c == '"') quoted = !quoted;
    german += quoted ? c : c == ',' ? ';' : c == '.' ? ',' : c;
  }
  const Dataset expected = load(SyntheticLog::config(), csv);
  LogConfig config = SyntheticLog::config();
  const auto expect_the_same = [&] {
    const Dataset data = load(config, german);
    EXPECT_EQ(data.trajectories[0].outputs, expected.trajectories[0].outputs);
    EXPECT_EQ(data.trajectories[0].states, expected.trajectories[0].states);
  };
  expect_the_same();  // the format is found in the file
  config.separator = ";";
  expect_the_same();
  config.decimal = ",";
  expect_the_same();
}

TEST_F(LogDataset, RefusesAnEveryThatLeavesTooFewRows) {
  LogConfig config = SyntheticLog::config();
  config.every = 600;
  config.sample_period_s *= 600;
  EXPECT_THAT(error_in(config, log_.csv()),
              HasSubstr("log.csv: has 600 rows, of which every = 600 leaves fewer than two samples"));
}

}  // namespace
}  // namespace nlo::trainer
