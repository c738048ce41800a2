// SPDX-License-Identifier: MIT
#include "trainer/data/log_dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <sstream>

#include "tests/data/testing.h"

namespace nlo::trainer {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
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

TEST_F(LogDataset, ComputesOutputsOfOthersAndOfInputsAndMissesThemWhereAPartIsEmpty) {
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
  ASSERT_EQ(report_.files.size(), 1u);  // one log
  EXPECT_EQ(report_.files[0].runs, 2u);
  EXPECT_EQ(report_.files[0].samples, 550);
  EXPECT_LT(report_.files[0].max_s, 0.01);  // the gap is not a step of either run
  EXPECT_THAT(to_text(report_), HasSubstr("log.csv (2 runs)      550"));
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
              ElementsAre(HasSubstr("split into 3 runs"),
                          AllOf(HasSubstr("unusable, and dropped: 1 of its 3 runs, the first log.csv (2 of 3)"),
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

/// t, a measured, b the truth and u an input: 400 rows at 100 Hz, with the cell of row k in a column left empty where `empty`
/// says so.
std::string holey_log(const std::function<bool(int, char)>& empty) {
  std::string text = "time,a,b,u\n";
  for (int k = 0; k < 400; ++k) {
    const auto cell = [&](char column, double value) {
      return empty(k, column) ? std::string(k % 2 == 0 ? "" : "NaN") : std::to_string(value);
    };
    text += std::to_string(0.01 * k) + "," + cell('a', std::sin(0.05 * k)) + "," + cell('b', 2.0 + 0.01 * k) + "," +
            cell('u', std::cos(0.03 * k)) + "\n";
  }
  return text;
}

LogConfig holey_config() {
  LogConfig config;
  config.columns = {column("time", ColumnRole::kTime), column("a", ColumnRole::kOutput, {.unit = "m"}),
                    column("b", ColumnRole::kState), column("u", ColumnRole::kInput)};
  return config;
}

TEST_F(LogDataset, AnEmptyCellIsMissingInAnOutputHeldInAnInputAndUnscoredInAState) {
  const Dataset whole = load(holey_config(), holey_log([](int, char) { return false; }));
  EXPECT_TRUE(report_.notes.empty()) << report_.notes[0];  // control
  EXPECT_EQ(whole.trajectories[0].missing.size(), 0);
  const auto empty = [](int k, char column) {
    return (column == 'a' && k >= 100 && k < 110) || (column == 'b' && k >= 200 && k < 220) ||
           (column == 'u' && k == 300);
  };
  const Dataset data = load(holey_config(), holey_log(empty));
  ASSERT_EQ(data.trajectories.size(), 1u);
  const Trajectory &run = data.trajectories[0], &full = whole.trajectories[0];
  ASSERT_EQ(run.samples(), 400);
  EXPECT_TRUE(data.uniform);
  ASSERT_EQ(run.missing.rows(), 1);
  for (int k = 0; k < 400; ++k) {
    const bool lost = empty(k, 'a');
    ASSERT_EQ(run.missing(0, k), lost) << k;
    ASSERT_EQ(run.outputs(0, k), full.outputs(0, lost ? 99 : k)) << k;
    ASSERT_EQ(std::isnan(run.measured()(0, k)), lost) << k;
    ASSERT_EQ(run.inputs(0, k), full.inputs(0, k == 300 ? 299 : k)) << k;
    ASSERT_EQ(run.weight[k], empty(k, 'b') ? 0.0 : 1.0) << k;
    ASSERT_NEAR(run.states(0, k), full.states(0, k), 1e-9) << k;  // a line through the hole, and b is one
  }
  EXPECT_THAT(
      report_.notes,
      ElementsAre(AllOf(HasSubstr("\"a\" has no value in 2.5 % of the rows (10 of 400, for up to 0.11 s, most in "
                                  "log.csv): as an output it holds its last value there"),
                        HasSubstr("may_fail")),
                  HasSubstr("\"b\" has no value in 5 % of the rows (20 of 400, for up to 0.21 s, most in log.csv): as "
                            "a state it is not scored there"),
                  HasSubstr("\"u\" has no value in 0.25 % of the rows (1 of 400")));
}

TEST_F(LogDataset, ARunBeginsWhereEveryOutputAndInputHasAValue) {
  const Dataset data = load(holey_config(), holey_log([](int k, char column) {
                              return (column == 'a' && k < 7) || (column == 'u' && k < 12) || (column == 'b' && k < 50);
                            }));
  ASSERT_EQ(data.trajectories.size(), 1u);
  const Trajectory& run = data.trajectories[0];
  EXPECT_EQ(run.samples(), 388);
  EXPECT_EQ(run.time_s[0], 0.0);
  EXPECT_NEAR(run.outputs(0, 0), std::sin(0.05 * 12), 1e-6);
  EXPECT_EQ(run.weight.head(38).sum(), 0.0);  // the truth begins later: the observer runs in meanwhile
  EXPECT_EQ(run.weight.tail(350).sum(), 350.0);
  EXPECT_THAT(report_.notes, Contains(HasSubstr("log.csv: 12 rows are left out")));
}

TEST_F(LogDataset, NamesAllColumnsThatAreMostlyEmpty) {
  // Three topics in one table: each row has one of them.
  const Dataset data = load(holey_config(), holey_log([](int k, char column) { return column != "abu"[k % 3]; }));
  EXPECT_EQ(report_.notes.size(), 4u);  // three columns and the first two rows
  for (const char* name : {"\"a\"", "\"b\"", "\"u\""})
    EXPECT_THAT(report_.notes,
                Contains(AllOf(HasSubstr(name), HasSubstr("has no value in 66."), HasSubstr(", mostly empty: "))));
  EXPECT_EQ(data.trajectories[0].weight.sum(), 132.0);  // 133 rows have b, one of them before the first u
  EXPECT_THAT(error_in(holey_config(), holey_log([](int k, char column) { return column == 'a' || k % 5 > 1; })),
              HasSubstr("log.csv: no row has a value of \"a\"; mostly empty: \"b\" (60 %), \"u\" (60 %): leave the log "
                        "out, or take the column out of [[log.columns]]"));
  LogConfig two = holey_config();
  two.columns.push_back(column("c", ColumnRole::kState, {.column = "a"}));
  EXPECT_THAT(error_in(two, holey_log([](int k, char column) { return column == "ab"[k % 2]; })),
              HasSubstr("no row has a value of every state"));
}

TEST_F(LogDataset, AVelocityIsUnscoredAroundALongHoleOfItsPosition) {
  LogConfig config = holey_config();
  config.columns[2] = column("b", ColumnRole::kState, {.derivative_of = "a"});
  const auto scored = [&](int from, int to) {
    const Dataset data =
        load(config, holey_log([=](int k, char column) { return column == 'a' && k >= from && k < to; }));
    const Trajectory& run = data.trajectories[0];
    for (int k = 0; k < run.samples(); ++k) {
      if (run.weight[k] > 0.0) {
        EXPECT_NEAR(run.states(0, k), 5.0 * std::cos(0.05 * k), 0.07) << k;  // of 5
      }
    }
    return run.weight;
  };
  const Eigen::VectorXd all = scored(0, 0), two = scored(200, 202), long_hole = scored(200, 230);
  for (int k = 0; k < 400; ++k) {
    ASSERT_EQ(two[k], k == 200 || k == 201 ? 0.0 : all[k]) << k;  // .03 s: shorter than a period of the cut-off
    ASSERT_EQ(long_hole[k], k > 199 - 20 && k < 230 + 20 ? 0.0 : all[k]) << k;
  }
}

TEST_F(LogDataset, MissingCellsGoWithTheirRowsWhereALogIsThinned) {
  LogConfig config = holey_config();
  config.every = 4;
  const Dataset data = load(config, holey_log([](int k, char column) { return column == 'a' && k >= 101 && k < 110; }));
  ASSERT_EQ(data.trajectories[0].missing.cols(), 100);
  for (int k = 0; k < 100; ++k) EXPECT_EQ(data.trajectories[0].missing(0, k), k == 26 || k == 27) << k;
}

TEST_F(LogDataset, ConvertsCellsBeforeAnglesUnwrapAndVelocitiesAreFiltered) {
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
  const Dataset velocity = load(config, csv);  // phi in deg, its velocity wanted in rad/s
  EXPECT_TRUE(velocity.trajectories[0].states.isApprox(radians.trajectories[0].states, 1e-7));
  EXPECT_GT(velocity.trajectories[0].outputs.maxCoeff(), 180.0);
}

TEST_F(LogDataset, ReadsAGermanExport) {
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
  EXPECT_THAT(error_in(config, german), HasSubstr("set separator = \";\" in [log]"));
  config.separator = ";";
  EXPECT_THAT(error_in(config, german), HasSubstr("set decimal = \",\" in [log]"));
  config.decimal = ",";
  const Dataset data = load(config, german);
  EXPECT_EQ(data.trajectories[0].outputs, expected.trajectories[0].outputs);
  EXPECT_EQ(data.trajectories[0].states, expected.trajectories[0].states);
}

TEST_F(LogDataset, RefusesToLeaveTooFewRows) {
  LogConfig config = SyntheticLog::config();
  config.every = 600;
  config.sample_period_s *= 600;
  EXPECT_THAT(error_in(config, log_.csv()), HasSubstr("log.csv: 600 rows, and every = 600 leaves no two samples"));
}

}  // namespace
}  // namespace nlo::trainer
