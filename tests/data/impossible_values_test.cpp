// SPDX-License-Identifier: MIT
#include "trainer/data/impossible_values.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "tests/data/data_testing.h"

namespace nlo::trainer {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Searches 1000 samples in two logs.
ImpossibleValues found_in(const std::function<double(int)>& value, bool is_command = false) {
  Eigen::VectorXd x(1000);
  for (int k = 0; k < 1000; ++k) x[k] = value(k);
  return impossible_values({x.head(400), x.tail(600)}, is_command);
}

std::vector<double> values_in(const std::function<double(int)>& value, bool is_command = false) {
  return found_in(value, is_command).values;
}

double sway(int k) {
  return 3.0 * std::sin(0.1 * k);
}

TEST(ImpossibleValues, AreFarOutsideOfAllOtherValues) {
  for (const double value : {-9999.0, -99.9, 65535.0, 655.35, -32768.0, 3.4028234663852886e38, -1e31, 77.0})
    EXPECT_THAT(values_in([&](int k) { return k % 97 == 5 ? value : sway(k); }), ElementsAre(value)) << value;
  EXPECT_THAT(values_in([](int k) { return k % 97 == 5    ? -9999.0
                                           : k % 211 == 9 ? 65535.0
                                                          : sway(k); }),
              ElementsAre(-9999.0, 65535.0));
  EXPECT_THAT(values_in([](int k) { return k / 100 == 3 ? -9999.0 : sway(k); }), ElementsAre(-9999.0))
      << "also in long bursts";
  EXPECT_THAT(values_in([](int k) { return k % 97 == 5 ? 4095.0 : 1500.0 + 500.0 * sway(k) / 3.0; }),
              ElementsAre(4095.0))
      << "an AD converter with values from 1000 to 2000";
  EXPECT_THAT(values_in([](int k) { return k % 97 == 5 ? -999.0 : k / 100 % 2; }), ElementsAre(-999.0))
      << "also in a column of flags";
  EXPECT_THAT(values_in([](int k) { return k % 97 == 5 ? 0.0 : 1013.0 + sway(k); }), ElementsAre(0.0));
}

TEST(ImpossibleValues, HaveACountAndAPlace) {
  const ImpossibleValues found = found_in([](int k) { return k % 97 == 5 ? -9999.0 : k == 450 ? 1e35 : sway(k); });
  EXPECT_EQ(found.count, 12);
  EXPECT_EQ(found.all, 1000);
  EXPECT_EQ(found.file, 0U);
  EXPECT_EQ(found.row, 5);
  EXPECT_NEAR(found.low, -3.0, 0.01);
  EXPECT_NEAR(found.high, 3.0, 0.01);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const ImpossibleValues late = found_in([&](int k) {
    return k < 10 ? nan : k % 100 == 50 && k > 400 ? -9999.0 : sway(k);
  });
  EXPECT_EQ(late.all, 990);
  EXPECT_EQ(late.file, 1U);
  EXPECT_EQ(late.row, 50);
}

TEST(ImpossibleValues, AreNotTheReadingsOfASpikySensor) {
  std::mt19937 engine(5);
  std::normal_distribution<double> noise(0.0, 0.1);
  std::exponential_distribution<double> impact(0.01);
  EXPECT_THAT(values_in([&](int k) { return noise(engine) + (k % 50 < 2 ? impact(engine) : 0.0); }), IsEmpty())
      << "a contact force";
  EXPECT_THAT(values_in([&](int k) { return noise(engine) + (k == 500 ? 300.0 : 0.0); }), IsEmpty()) << "one impact";
  EXPECT_THAT(values_in([&](int k) { return std::min(500.0, k % 50 < 3 ? 5.0 * impact(engine) : noise(engine)); }),
              IsEmpty())
      << "a contact force that sometimes saturates";
  EXPECT_THAT(values_in([&](int k) { return k % 30 == 0 ? std::exp(0.02 * k) : noise(engine); }), IsEmpty());
}

TEST(ImpossibleValues, AreNotCommandsAtALimit) {
  const auto one_end = [](int k) { return k % 40 < 4 ? 100.0 : sway(k); };
  const auto both_ends = [](int k) { return k % 40 < 4 ? 100.0 : k % 40 > 35 ? -100.0 : sway(k); };
  EXPECT_THAT(values_in(one_end, true), IsEmpty());
  EXPECT_THAT(values_in(both_ends, true), IsEmpty());
  EXPECT_THAT(values_in(both_ends), IsEmpty()) << "even if the column is not declared as a command";
  EXPECT_THAT(values_in([&](int k) { return k % 97 == 5 ? -9999.0 : both_ends(k); }, true), ElementsAre(-9999.0));
  EXPECT_THAT(values_in([](int k) { return k / 100 % 2 == 0 ? 0.0 : 100.0; }), IsEmpty())
      << "a valve that is open or closed";
}

TEST(ImpossibleValues, AreNotTheLimitOfASensorThatSaturates) {
  EXPECT_THAT(values_in([](int k) { return std::min(4095.0, std::round(3000.0 + 500.0 * sway(k))); }), IsEmpty());
  EXPECT_THAT(values_in([](int k) { return k / 100 % 2 == 0 ? 4095.0 : 1500.0 + 500.0 * sway(k) / 3.0; }), IsEmpty())
      << "saturated for half of the samples";
  EXPECT_THAT(values_in([](int k) { return k / 100 % 3 == 0 ? 4095.0 : 1500.0 + 500.0 * sway(k) / 3.0; }), IsEmpty())
      << "saturated for a second at a time";
}

TEST(ImpossibleValues, AreNotFoundInAColumnWithoutThem) {
  EXPECT_THAT(values_in(sway), IsEmpty());
  EXPECT_THAT(values_in([](int k) { return k / 100 == 3 ? 77.0 : sway(k); }), IsEmpty()) << "another state of the rig";
  EXPECT_THAT(values_in([](int k) { return k % 5 != 0 ? -9999.0 : sway(k); }), IsEmpty())
      << "most samples have this value";
  EXPECT_THAT(values_in([](int k) { return std::exp(0.01 * k); }), IsEmpty());
  EXPECT_THAT(values_in([](int k) { return k % 97 == 5 ? 99.0 : 90.0 * std::sin(0.1 * k); }), IsEmpty());
  EXPECT_THAT(values_in([](int) { return 7.0; }), IsEmpty());
  EXPECT_THAT(values_in([](int) { return -9999.0; }), IsEmpty());
}

class MissingValues : public LoadingLogs {
 protected:
  /// A log whose angle is `cell` in every hundredth row.
  static std::string csv(const char* cell = "-9999") {
    std::string text = "time,y,x\n";
    for (int k = 0; k < 600; ++k) {
      char row[96];
      std::snprintf(row, sizeof row, "%.3f,%s,%.9g\n", 0.01 * k, k % 100 == 50 ? cell : std::to_string(sway(k)).c_str(),
                    std::cos(0.1 * k));
      text += row;
    }
    return text;
  }
  static LogConfig config() {
    LogConfig log;
    log.columns = {column("time", ColumnRole::kTime, {.unit = "s"}), column("y", ColumnRole::kOutput, {.unit = "rad"}),
                   column("x", ColumnRole::kState)};
    return log;
  }
};

TEST_F(MissingValues, AreReportedOnceWithLineColumnShareAndKey) {
  load(config(), csv());
  EXPECT_THAT(report_.notes,
              ElementsAre("log.csv:52: \"y\" is -9999 here and in 1 % of its rows; elsewhere it is from -3 to "
                          "3: if these are not readings, write missing = [-9999] at the column"));
  load(config(), csv("1.7976931348623157e308"));
  EXPECT_THAT(report_.notes, ElementsAre(HasSubstr("write missing = [\"1.7976931348623157e+308\"]")));
  load(config(), csv("0.1"));  // control
  EXPECT_THAT(report_.notes, IsEmpty());
}

TEST_F(MissingValues, AreMissingSamplesIfAKeyNamesThem) {
  for (const bool of_column : {false, true})
    for (const char* cell : {"-9999", "-9999.0", "-9.999e3", "ERR"}) {
      LogConfig log = config();
      (of_column ? log.columns[1].missing : log.missing) = {"-9999", "ERR"};
      const Dataset data = load(log, csv(cell));
      const Trajectory& run = data.trajectories[0];
      ASSERT_EQ(run.samples(), 600);
      EXPECT_EQ(run.missing.count(), 6) << cell;
      EXPECT_TRUE(run.missing(0, 50));
      EXPECT_NEAR(run.outputs(0, 50), sway(49), 1e-6) << "the last value is held";
      EXPECT_THAT(report_.notes, ElementsAre(HasSubstr("\"y\" has no value in 1 % of the rows")));
    }
  LogConfig other = config();
  other.columns[2].missing = {"ERR"};
  EXPECT_THAT(error_in(other, csv("ERR")),
              HasSubstr("log.csv:52:y: \"ERR\" is not a number: correct the row or delete it; if it marks a missing "
                        "value, write missing = [\"ERR\"] at the column"));
}

TEST_F(MissingValues, AreNotScoredIfTheColumnIsATruth) {
  LogConfig log = config();
  std::swap(log.columns[1].role, log.columns[2].role);
  log.missing = {"-9999"};
  EXPECT_EQ(load(log, csv()).trajectories[0].weight.sum(), 594.0);
  log.missing.clear();
  load(log, csv());
  EXPECT_THAT(report_.notes, ElementsAre(HasSubstr("write missing = [-9999]")))
      << "reported once, and not as an outlier";
}

TEST_F(MissingValues, AreMissingInTheVelocityOfAnAngle) {
  LogConfig log = config();
  log.columns[1].missing = {"-9999"};
  log.columns[2] = column("rate", ColumnRole::kState, {.derivative_of = "y"});
  const Dataset data = load(log, csv());
  EXPECT_EQ(data.trajectories[0].weight[50], 0.0);
  EXPECT_LT(data.trajectories[0].states.cwiseAbs().maxCoeff(), 100.0);
}

TEST_F(MissingValues, DoNotApplyToTimeOrExpressions) {
  LogConfig log = config();
  log.columns[0].missing = {"0"};
  EXPECT_THAT(error_in(log, csv()), AllOf(HasSubstr("\"time\""), HasSubstr("missing is not needed at the time")));
  log = config();
  log.columns.push_back(column("yy", ColumnRole::kOutput));
  log.columns.back().expression = "y * y";
  log.columns.back().missing = {"0"};
  EXPECT_THAT(error_in(log, csv()), HasSubstr("remove missing"));
}

}  // namespace
}  // namespace nlo::trainer
