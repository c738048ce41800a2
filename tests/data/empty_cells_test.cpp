// SPDX-License-Identifier: MIT
#include "trainer/data/empty_cells.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tests/data/data_testing.h"

namespace nlo::trainer {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

using EmptyCellsOfLogs = LoadingLogs;

/// t, a measured output a, the truth b and an input u: 400 rows at 100 Hz. The cell of row k in a column is empty if
/// `empty` returns true.
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

TEST_F(EmptyCellsOfLogs, AnEmptyCellMeansMissingForAnOutputHeldForAnInputAndUnscoredForAState) {
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
    // Linear interpolation across the gap, and b is linear.
    ASSERT_NEAR(run.states(0, k), full.states(0, k), 1e-9) << k;
  }
  EXPECT_THAT(
      report_.notes,
      ElementsAre(AllOf(HasSubstr("\"a\" has no value in 2.5 % of the rows (10 of 400, for up to 0.11 s, most in "
                                  "log.csv): as an output it holds its last value there"),
                        HasSubstr("may_fail")),
                  HasSubstr("\"b\" has no value in 5 % of the rows (20 of 400, for up to 0.21 s, most in log.csv): as "
                            "a state: no state is scored in these rows"),
                  HasSubstr("\"u\" has no value in 0.25 % of the rows (1 of 400")));
}

TEST_F(EmptyCellsOfLogs, AnOutputWithItsOwnPeriodMissesOnlySamplesThatWereDue) {
  const auto slow = [](int k, char column) { return column == 'a' && k % 20 != 0; };
  const Dataset unsaid = load(holey_config(), holey_log(slow));
  EXPECT_EQ(unsaid.outputs[0].period_s, 0.0);
  EXPECT_THAT(report_.notes, ElementsAre(AllOf(HasSubstr("\"a\" has no value in 95 % of the rows"),
                                               HasSubstr("write period_s = 0.2 at the column"))));
  LogConfig config = holey_config();
  config.columns[1].period_s = 0.2;
  const Dataset data = load(config, holey_log(slow));
  EXPECT_TRUE(report_.notes.empty()) << report_.notes[0];
  EXPECT_EQ(data.outputs[0].period_s, 0.2);
  EXPECT_EQ(data.trajectories[0].outputs, unsaid.trajectories[0].outputs);  // held between its samples
  const auto lossy = [&](int k, char column) { return slow(k, column) || (column == 'a' && k > 100 && k < 170); };
  load(config, holey_log(lossy));
  EXPECT_THAT(report_.notes, ElementsAre(HasSubstr("\"a\" lacks 3 of its 21 samples with period_s = 0.2 s (for up to "
                                                   "0.8 s, in log.csv)")));
  config.columns[1].period_s = 0.012;
  EXPECT_THAT(error_in(config, holey_log(slow)),
              HasSubstr("\"a\": period_s = 0.012 is not longer than the sample period, 0.01 s: remove it"));
  config.columns[1].period_s = 0.0;
  config.columns[2].period_s = 0.2;
  EXPECT_THAT(error_in(config, holey_log(slow)), HasSubstr("\"b\": period_s is only for columns with role \"output\""));
}

TEST(RegularSpacing, IsTheMeanOfTheSpacingsNearTheMedianIfTheyAreNineOfTen) {
  const auto spacing = [](const std::function<bool(Eigen::Index)>& has_value) {
    std::vector<Eigen::Index> empty;
    for (Eigen::Index row = 0; row < 200; ++row)
      if (!has_value(row)) empty.push_back(row);
    return regular_spacing(empty, 200);
  };
  EXPECT_EQ(spacing([](auto row) { return row % 8 == 3; }), 8);
  EXPECT_EQ(spacing([](auto row) { return row % 8 == (row / 8) % 2; }), 8) << "jitter of one row: 7 or 9 rows apart";
  EXPECT_EQ(spacing([](auto row) { return row % 8 == 3 && row != 83; }), 8) << "one value is missing";
  EXPECT_EQ(spacing([](auto row) { return row % 8 == 3 && row / 8 % 3 != 0; }), 0)
      << "control: a third of the values is missing";
  EXPECT_EQ(spacing([](auto row) { return row % 8 != 3; }), 0) << "control: a value in most rows";
  EXPECT_EQ(spacing([](auto) { return true; }), 0);
  EXPECT_EQ(spacing([](auto row) { return row % 80 == 0; }), 0) << "three values do not determine a period";
}

TEST_F(EmptyCellsOfLogs, ARunBeginsWhenEveryOutputAndInputHasAValue) {
  const Dataset data = load(holey_config(), holey_log([](int k, char column) {
                              return (column == 'a' && k < 7) || (column == 'u' && k < 12) || (column == 'b' && k < 50);
                            }));
  ASSERT_EQ(data.trajectories.size(), 1u);
  const Trajectory& run = data.trajectories[0];
  EXPECT_EQ(run.samples(), 388);
  EXPECT_EQ(run.time_s[0], 0.0);
  EXPECT_NEAR(run.outputs(0, 0), std::sin(0.05 * 12), 1e-6);
  EXPECT_EQ(run.weight.head(38).sum(), 0.0);  // the truth begins later; the observer already runs
  EXPECT_EQ(run.weight.tail(350).sum(), 350.0);
  EXPECT_THAT(report_.notes, Contains(HasSubstr("log.csv: 12 rows at the start of runs are left out")));
}

TEST_F(EmptyCellsOfLogs, NamesAllColumnsThatAreMostlyEmpty) {
  // Three topics in one table: each row has a value of one topic.
  const Dataset data = load(holey_config(), holey_log([](int k, char column) { return column != "abu"[k % 3]; }));
  EXPECT_EQ(report_.notes.size(), 4u);  // three columns, and a note on the first two rows
  for (const char* name : {"\"a\"", "\"b\"", "\"u\""})
    EXPECT_THAT(report_.notes,
                Contains(AllOf(HasSubstr(name), HasSubstr("has no value in 66."), HasSubstr(", mostly empty: "))));
  EXPECT_EQ(data.trajectories[0].weight.sum(), 132.0);  // 133 rows have b, one of which precedes the first u
  EXPECT_THAT(error_in(holey_config(), holey_log([](int k, char column) { return column == 'a' || k % 5 > 1; })),
              HasSubstr("log.csv: no row has a value of \"a\"; mostly empty: \"b\" (60 %), \"u\" (60 %): leave the log "
                        "out, or remove the column from [[log.columns]]"));
  LogConfig two = holey_config();
  two.columns.push_back(column("c", ColumnRole::kState, {.column = "a"}));
  EXPECT_THAT(error_in(two, holey_log([](int k, char column) { return column == "ab"[k % 2]; })),
              HasSubstr("no row has a value of every state"));
}

TEST_F(EmptyCellsOfLogs, AVelocityIsUnscoredAroundALongGapOfItsPosition) {
  LogConfig config = holey_config();
  config.columns[2] = column("b", ColumnRole::kState, {.derivative_of = "a"});
  const auto scored = [&](int from, int to) {
    const Dataset data =
        load(config, holey_log([=](int k, char column) { return column == 'a' && k >= from && k < to; }));
    const Trajectory& run = data.trajectories[0];
    for (int k = 0; k < run.samples(); ++k) {
      if (run.weight[k] > 0.0) {
        EXPECT_NEAR(run.states(0, k), 5.0 * std::cos(0.05 * k), 0.07) << k;  // the amplitude is 5
      }
    }
    return run.weight;
  };
  const Eigen::VectorXd all = scored(0, 0), two = scored(200, 202), long_hole = scored(200, 230);
  for (int k = 0; k < 400; ++k) {
    ASSERT_EQ(two[k], k == 200 || k == 201 ? 0.0 : all[k]) << k;  // .03 s, shorter than a period of the cut-off
    ASSERT_EQ(long_hole[k], k > 199 - 20 && k < 230 + 20 ? 0.0 : all[k]) << k;
  }
}

TEST_F(EmptyCellsOfLogs, MissingCellsStayWithTheirRowsIfALogIsThinned) {
  LogConfig config = holey_config();
  config.every = 4;
  const Dataset data = load(config, holey_log([](int k, char column) { return column == 'a' && k >= 101 && k < 110; }));
  ASSERT_EQ(data.trajectories[0].missing.cols(), 100);
  for (int k = 0; k < 100; ++k) EXPECT_EQ(data.trajectories[0].missing(0, k), k == 26 || k == 27) << k;
}

}  // namespace
}  // namespace nlo::trainer
