// SPDX-License-Identifier: MIT
#include "trainer/data/guess/log_guess.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "codegen/base/error.h"
#include "codegen/base/identifier.h"
#include "tests/support/scratch_directory.h"
#include "tests/support/thrown_message.h"
#include "trainer/base/number_text.h"
#include "trainer/data/csv_format.h"
#include "trainer/data/guess/column_numbers.h"
#include "trainer/data/guess/heading.h"
#include "trainer/data/guess/role_word.h"

namespace nlo::trainer {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kTurn = 2.0 * std::numbers::pi;

class LogGuess : public testing::Test {
 protected:
  /// Writes a log of `rows` rows; `cells` returns the text of row k.
  std::string write(const std::string& file, const std::string& header, const std::function<std::string(int)>& cells,
                    int rows = 200) const {
    std::string text = header + "\n";
    for (int k = 0; k < rows; ++k) text += cells(k) + "\n";
    return folder_.write(file, text);
  }

  GuessedLog guess(const std::string& header, const std::function<std::string(int)>& cells,
                   const LogHints& hints = {}) const {
    return guess_log({write("log.csv", header, cells)}, hints);
  }

  ScratchDirectory folder_;
};

/// Joins cells by commas.
std::string row(std::initializer_list<double> cells) {
  std::string text;
  for (const double cell : cells) text += (text.empty() ? "" : ",") + shortest_text(cell);
  return text;
}

/// Returns a number with a decimal comma.
std::string fmt_comma(double value) {
  std::string text = shortest_text(value);
  if (const auto point = text.find('.'); point != std::string::npos) text[point] = ',';
  return text;
}

const GuessedColumn& column(const GuessedLog& log, const std::string& name) {
  for (const GuessedColumn& each : log.columns)
    if (each.name == name) return each;
  throw codegen::Error("no column " + name);
}

TEST_F(LogGuess, ReadsRolesUnitsAndTheClockOfARig) {
  const GuessedLog log = guess("timestamp_ms,baro_hpa,acc [g],thrust_pct,height_cm", [](int k) {
    return row(
        {20.0 * k, 1013.0 + 0.01 * std::sin(0.1 * k), std::cos(0.1 * k), 50.0 + k % 7, 100.0 * std::sin(0.1 * k)});
  });
  EXPECT_EQ(log.clock.heading, "timestamp_ms");
  EXPECT_EQ(log.clock.unit, "ms");
  EXPECT_NEAR(log.clock.period_s, 0.02, 1e-12);
  EXPECT_EQ(column(log, "baro").role, ColumnRole::kOutput);
  EXPECT_EQ(column(log, "baro").unit, "hPa");
  EXPECT_EQ(column(log, "acc").role, ColumnRole::kOutput);
  EXPECT_EQ(column(log, "acc").unit, "g");
  EXPECT_EQ(column(log, "thrust").role, ColumnRole::kInput);
  EXPECT_EQ(column(log, "height").role, ColumnRole::kState);
  EXPECT_THAT(column(log, "height").why, HasSubstr("CHECK"));
  EXPECT_THAT(log.undecided(), IsEmpty());
}

TEST_F(LogGuess, LeavesRolesOpenThatNumbersDoNotShow) {
  const auto cells = [](int k) {
    return row({0.01 * k, std::sin(0.1 * k), std::cos(0.1 * k), 0.5 * std::sin(0.3 * k)});
  };
  const GuessedLog open = guess("time,position,velocity,strain", cells);
  EXPECT_THAT(open.undecided(), ElementsAre("position", "velocity", "strain"));
  EXPECT_EQ(open.count(ColumnRole::kOutput) + open.count(ColumnRole::kState), 0U);
  const GuessedLog with_hints =
      guess("time,position,velocity,strain", cells, {{"velocity"}, {"position"}, {"strain"}, 0.0});
  EXPECT_THAT(with_hints.undecided(), IsEmpty());
  EXPECT_EQ(column(with_hints, "velocity").role, ColumnRole::kState);
  EXPECT_EQ(column(with_hints, "position").role, ColumnRole::kOutput);
  EXPECT_EQ(column(with_hints, "strain").role, ColumnRole::kInput);
  // A measured column may also be the truth; it is then listed as two columns.
  const GuessedLog both =
      guess("time,position,velocity,strain", cells, {{"position", "velocity"}, {"position"}, {}, 0.0});
  EXPECT_EQ(column(both, "position").role, ColumnRole::kState);
  EXPECT_EQ(column(both, "position_measured").role, ColumnRole::kOutput);
  EXPECT_EQ(column(both, "position_measured").heading, "position");
  EXPECT_EQ(column(both, "strain").why, "no option names it");
}

TEST_F(LogGuess, TreatsAColumnWithAValueInEveryNthRowAsASlowSensor) {
  const auto log = [](int period, bool slow_truth) {
    return [=](int k) {
      const auto slow = [&](double value) { return k % period == 0 ? shortest_text(value) : std::string(); };
      return row({0.01 * k, std::sin(0.1 * k)}) + "," + slow(std::cos(0.1 * k)) + "," +
             (slow_truth ? slow(0.1 * k * k) : shortest_text(0.1 * k * k));
    };
  };
  const GuessedLog two_rates = guess("time,acc,pos,v", log(20, false));
  EXPECT_EQ(column(two_rates, "acc").period_s, 0.0);
  EXPECT_EQ(column(two_rates, "pos").role, ColumnRole::kOutput);
  EXPECT_THAT(column(two_rates, "pos").why, HasSubstr("it has a value in every 20th row"));
  EXPECT_NEAR(column(two_rates, "pos").period_s, 0.2, 1e-9);  // rounding of the stamps
  EXPECT_EQ(column(two_rates, "v").role, ColumnRole::kState);
  const GuessedLog one_rate = guess("time,acc,pos,v", log(1, false));
  EXPECT_EQ(column(one_rate, "pos").role, ColumnRole::kState) << "control";
  EXPECT_EQ(column(one_rate, "pos").period_s, 0.0);
  const GuessedLog slow_truth = guess("time,acc,pos,v", log(20, true));
  EXPECT_EQ(column(slow_truth, "pos").role, ColumnRole::kState) << "control: all other columns are slow";
}

/// Roles of columns with these headings, in their order; each column has its own varying numbers.
std::vector<ColumnRole> roles_of(const std::vector<std::string>& headings) {
  std::vector<Heading> parsed;
  for (const std::string& heading : headings) parsed.push_back(read_heading(heading, headings));
  std::vector<ColumnRole> roles;
  for (const Heading& heading : parsed) roles.push_back(role_word(heading, parsed).role);
  return roles;
}

TEST(RoleWord, MatchesWholeWordsInAnyCaseWithOrWithoutANumber) {
  constexpr auto kIn = ColumnRole::kInput, kOut = ColumnRole::kOutput, kNone = ColumnRole::kIgnored;
  EXPECT_THAT(roles_of({"cmd_vel.linear.x", "cmdVel", "Motor PWM2", "STEERING", "u_cmd", "SteeringWheelAngle [deg]"}),
              testing::Each(kIn));
  EXPECT_THAT(roles_of({"leftWheelSpeed", "IMUGyroZ", "odom/twist/x", "encoder_1", "hall3"}), testing::Each(kOut));
  EXPECT_THAT(roles_of({"ax", "ay", "gx", "gz"}), testing::Each(kOut));
  EXPECT_THAT(roles_of({"ax", "gx"}), testing::Each(kNone)) << "control: one axis alone is a name";
  // Controls: parts of words do not count.
  EXPECT_THAT(roles_of({"cmdr", "refraction", "wheelhouse", "modest", "i_d", "throttled"}), testing::Each(kNone));
}

TEST(RoleWord, TreatsASetPointAsAnInputOnlyIfNoCommandFollowsFromIt) {
  EXPECT_THAT(roles_of({"speed", "set_point"}), ElementsAre(ColumnRole::kIgnored, ColumnRole::kInput));
  EXPECT_THAT(roles_of({"SpeedRef", "steering_ref", "duty"}),
              ElementsAre(ColumnRole::kIgnored, ColumnRole::kInput, ColumnRole::kInput));
}

TEST(RoleWord, VoltageIsMeasuredForABatteryAndCommandedForAMotor) {
  EXPECT_THAT(roles_of({"Voltage(V)", "Current(A)", "T", "SoC"}),
              ElementsAre(ColumnRole::kOutput, ColumnRole::kInput, ColumnRole::kOutput, ColumnRole::kState));
  EXPECT_THAT(roles_of({"voltage", "current", "T", "battery_voltage"}),
              ElementsAre(ColumnRole::kInput, ColumnRole::kIgnored, ColumnRole::kIgnored, ColumnRole::kIgnored));
}

TEST_F(LogGuess, NeverTreatsTheClockAsATruthToEstimate) {
  const GuessedLog log = guess("time,ros_stamp,uptime_ms,gyro,angle,T", [](int k) {
    return row({0.01 * k, 1.7e9 + 0.01 * k + 0.001 * (k % 3), 10.0 * k + k % 2, std::sin(0.1 * k), std::cos(0.1 * k),
                20.0 + std::sin(0.2 * k)});
  });
  EXPECT_EQ(log.clock.heading, "time");
  for (const char* name : {"ros_stamp", "uptime"}) {
    EXPECT_EQ(column(log, name).role, ColumnRole::kIgnored) << name;
    EXPECT_THAT(column(log, name).why, HasSubstr("a time, but \"time\" is the clock"));
  }
  EXPECT_EQ(column(log, "angle").role, ColumnRole::kState) << "control";
  EXPECT_EQ(column(log, "t").role, ColumnRole::kState) << "control: it goes up and down";
  EXPECT_THAT(log.notes, IsEmpty()) << "the clock is found before T is considered";
}

TEST_F(LogGuess, AsksForOneColumnIfStampsAreSplitInTwo) {
  const auto cells = [](int k) {
    return std::to_string(1700000000 + k / 50) + "," + std::to_string(k % 50 * 20000000) + "," +
           row({std::sin(0.1 * k), std::cos(0.1 * k)});
  };
  const GuessedLog log = guess("header.stamp.sec,header.stamp.nanosec,gyro,x", cells);
  EXPECT_EQ(log.clock.heading, "");
  EXPECT_THAT(log.notes,
              ElementsAre(HasSubstr(
                  "\"header.stamp.sec\" and \"header.stamp.nanosec\" contain one time stamp in two columns")));
  EXPECT_EQ(column(log, "header_stamp_sec").role, ColumnRole::kIgnored);
  EXPECT_EQ(column(log, "x").role, ColumnRole::kState);
  const GuessedLog with_time = guess("time,stamp_sec,stamp_nanosec,gyro", [&](int k) {
    return row({0.02 * k}) + "," + cells(k).substr(0, cells(k).rfind(','));
  });
  EXPECT_EQ(with_time.clock.heading, "time");
  EXPECT_THAT(with_time.notes, IsEmpty()) << "control: another column is the clock, so nothing is asked";
}

TEST_F(LogGuess, TreatsAMeasurableQuantityAsTruthOnlyIfNothingElseIsLeft) {
  const auto cells = [](int k) {
    return row({0.01 * k, std::sin(0.1 * k), std::cos(0.1 * k), std::sin(0.3 * k), std::sin(0.2 * k)});
  };
  const GuessedLog car = guess("t,acc_x,yaw_rate,current_a,v", cells);
  EXPECT_EQ(column(car, "yaw_rate").role, ColumnRole::kOutput);
  EXPECT_THAT(column(car, "yaw_rate").why, HasSubstr("CHECK: \"yaw rate\""));
  EXPECT_EQ(column(car, "current").role, ColumnRole::kOutput);
  EXPECT_EQ(column(car, "v").role, ColumnRole::kState);
  const GuessedLog open = guess("t,acc_x,yaw_rate,current_a,gyro", cells);
  EXPECT_THAT(open.undecided(), ElementsAre("yaw_rate", "current"));
  EXPECT_EQ(open.count(ColumnRole::kState), 0U);
}

TEST_F(LogGuess, NamesTheNearestColumnOfAWrongHint) {
  EXPECT_THAT(thrown_message([&] {
                guess("time,position,velocity",
                      [](int k) {
                        return row({0.01 * k, 1.0 * (k % 5), 1.0 * (k % 3)});
                      },
                      {{"velocty"}, {}, {}, 0.0});
              }),
              HasSubstr("--states velocty: there is no such column; did you mean \"velocity\"?"));
}

TEST_F(LogGuess, DetectsAnglesThatJumpByATurn) {
  const auto wrapped = [](double angle, double turn) { return angle - turn * std::floor(angle / turn + 0.5); };
  const GuessedLog log = guess("t,arm_sensor,heading_sensor,swing_sensor,square_sensor", [&](int k) {
    return row({0.01 * k, wrapped(0.2 * k, kTurn), wrapped(7.0 * k, 360.0) + 180.0, 3.1 * std::sin(0.1 * k),
                k % 10 < 5 ? 3.1 : -3.1});
  });
  EXPECT_NEAR(column(log, "arm_sensor").wrap, kTurn, 1e-12);
  EXPECT_EQ(column(log, "arm_sensor").unit, "rad");
  EXPECT_EQ(column(log, "heading_sensor").wrap, 360.0);
  EXPECT_EQ(column(log, "heading_sensor").unit, "deg");
  EXPECT_EQ(column(log, "swing_sensor").wrap, 0.0) << "its range is as wide, but it never jumps";
  // The log has no truth, so the rates of the angles are computed from the log.
  EXPECT_EQ(column(log, "arm_sensor_rate").derivative_of, "arm_sensor");
  EXPECT_EQ(column(log, "arm_sensor_rate").unit, "rad/s");
}

TEST_F(LogGuess, ProposesAWrapFromUnitAndRangeIfNoLogCrossesIt) {
  const GuessedLog log = guess(
      "t,yaw_sensor_deg,arm_sensor_rad,turret_sensor_deg,pitch_sensor_deg,rate_sensor_dps,joint_sensor_deg", [](int k) {
        const double swing = std::sin(0.1 * k);
        return row(
            {0.01 * k, 175.0 * swing, 3.0 * swing, 180.0 + 170.0 * swing, 85.0 * swing, 175.0 * swing, 100.0 * swing});
      });
  EXPECT_EQ(column(log, "yaw_sensor").wrap, 360.0);
  EXPECT_FALSE(column(log, "yaw_sensor").jumps);
  EXPECT_NEAR(column(log, "arm_sensor").wrap, kTurn, 1e-12);
  EXPECT_EQ(column(log, "turret_sensor").wrap, 360.0);
  EXPECT_EQ(column(log, "pitch_sensor").wrap, 0.0) << "control: an angle below 90 degrees";
  EXPECT_EQ(column(log, "rate_sensor").wrap, 0.0) << "control: its unit is not that of an angle";
  EXPECT_EQ(column(log, "joint_sensor").wrap, 0.0) << "control: far from half a turn";
  const GuessedLog wide = guess("t,yaw_sensor_deg,north_sensor_deg", [](int k) {
    return row({0.01 * k, 200.0 * std::sin(0.1 * k), 174.0 + 0.1 * std::sin(0.1 * k)});
  });
  EXPECT_EQ(column(wide, "yaw_sensor").wrap, 0.0) << "control: more than one turn, so it is unwrapped";
  EXPECT_EQ(column(wide, "north_sensor").wrap, 0.0) << "control: hardly moves";
}

TEST_F(LogGuess, KeepsAClockWithAFewWrongStampsAndNamesThem) {
  const GuessedLog log = guess("time,y", [](int k) {
    return row({k == 50 ? 0.0 : 0.01 * (k % 40 == 3 ? k - 1 : k < 150 ? k : k - 150), std::sin(0.1 * k)});
  });
  EXPECT_EQ(log.clock.heading, "time");
  EXPECT_NEAR(log.clock.period_s, 0.01, 1e-12);
  EXPECT_LT(log.clock.deviation, 1e-6);
  EXPECT_NEAR(log.clock.duration_s, 1.49 + 0.49, 1e-9);
  EXPECT_THAT(log.notes, ElementsAre(HasSubstr("log.csv:152: the clock goes back"),
                                     HasSubstr("log.csv:52: the stamp 0 does not fit"),
                                     HasSubstr("log.csv:5: the stamp 0.02 equals that of the row before")));
}

TEST_F(LogGuess, ReadsTimesOfDayWithoutInventingAPeriod) {
  const auto clock = [](int k) {
    const std::string two = std::to_string(100 + k % 60);
    return "2026-11-20T10:0" + std::to_string(k / 60) + ":" + two.substr(1) + "Z," + shortest_text(std::sin(0.1 * k));
  };
  for (const char* header : {"time,y", "when,y"}) {
    const GuessedLog log = guess(header, clock);
    EXPECT_EQ(log.clock.heading, std::string(header).substr(0, 4));
    EXPECT_EQ(log.clock.unit, "s");
    EXPECT_NEAR(log.clock.period_s, 1.0, 1e-12);
  }
  const GuessedLog none = guess("time,y", [](int k) { return row({1.0 * (k / 4), std::sin(0.1 * k)}); });
  EXPECT_EQ(none.clock.period_s, 0.0);
  EXPECT_THAT(none.notes, ElementsAre(HasSubstr("\"time\" is named like a time but cannot be the clock:")));
}

TEST_F(LogGuess, ReadsUnitsFromTheRowBelowTheHeadings) {
  std::string text = "Logger 2.1\n\ntime,angle,rate\nms,[rad],rad/s\n";
  for (int k = 0; k < 50; ++k) text += row({10.0 * k, std::sin(0.1 * k), std::cos(0.1 * k)}) + "\n";
  const GuessedLog log = guess_log({folder_.write("units.csv", text)}, {});
  EXPECT_EQ(log.clock.unit, "ms");
  EXPECT_NEAR(log.clock.period_s, 0.01, 1e-12);
  EXPECT_EQ(column(log, "angle").unit, "rad");
  EXPECT_EQ(column(log, "rate").unit, "rad/s");
  EXPECT_EQ(log.rows, 50);
}

TEST_F(LogGuess, ReadsEachFileByItsOwnFormatAndLeavesDoubledHeadingsOut) {
  std::string other = "time;y_sensor;x;x\n";
  for (int k = 0; k < 200; ++k) other += fmt_comma(0.01 * k) + ";" + fmt_comma(std::sin(0.2 * k)) + ";0;0\n";
  const GuessedLog log = guess_log({write("a.csv", "time,y_sensor,x,x",
                                          [](int k) {
                                            return row({0.01 * k, std::sin(0.1 * k), 0.0, 0.0});
                                          }),
                                    folder_.write("b.csv", other)},
                                   {});
  EXPECT_EQ(log.rows, 400);
  EXPECT_EQ(log.format.separator, ',');
  EXPECT_NEAR(log.clock.period_s, 0.01, 1e-12);
  ASSERT_EQ(log.columns.size(), 1U);
  EXPECT_THAT(log.notes, ElementsAre(HasSubstr("b.csv: has other separators of cells or decimals than"),
                                     HasSubstr("several columns have the heading \"x\", so none of them is read")));
}

TEST_F(LogGuess, ProposesMissingForCellsThatMeanNoValue) {
  const GuessedLog log = guess("time,y_sensor,z_sensor,motor_cmd,x_true", [](int k) {
    return row({0.01 * k, k % 50 == 7 ? -9999.0 : std::sin(0.1 * k)}) + "," +
           (k % 50 == 9 ? "ERR" : shortest_text(std::sin(0.2 * k))) + "," +
           row({k % 100 < 4 ? 100.0 : std::sin(0.3 * k), std::cos(0.1 * k)});
  });
  EXPECT_THAT(column(log, "y_sensor").missing, ElementsAre("-9999"));
  EXPECT_GT(column(log, "y_sensor").low, -1.1) << "its range is that of the other cells";
  EXPECT_THAT(column(log, "z_sensor").missing, ElementsAre("ERR"));
  EXPECT_EQ(column(log, "z_sensor").role, ColumnRole::kOutput);
  EXPECT_THAT(column(log, "motor_cmd").missing, IsEmpty()) << "a command at its limit";
  EXPECT_THAT(column(log, "x_true").missing, IsEmpty());
  EXPECT_THAT(log.notes, ElementsAre(HasSubstr("log.csv:9: \"y_sensor\" is -9999 here and in 2 % of its rows"),
                                     HasSubstr("log.csv:11: \"z_sensor\" is \"ERR\" here and in 2 % of its rows")));
}

TEST_F(LogGuess, IgnoresAColumnOfWords) {
  const GuessedLog log = guess("time,y_sensor,mode", [](int k) {
    return row({0.01 * k, std::sin(0.1 * k)}) + (k % 5 == 0 ? ",1" : k % 2 == 0 ? ",idle" : ",run");
  });
  EXPECT_THAT(column(log, "mode").why, HasSubstr("its cells are not numbers: \"run\""));
  EXPECT_THAT(column(log, "mode").missing, IsEmpty());
}

TEST_F(LogGuess, FindsTheUnitOfStampsWithoutAUnit) {
  const auto unit = [&](double step) {
    return guess("time,y", [step](int k) { return row({step * k, std::sin(0.1 * k)}); }).clock.unit;
  };
  EXPECT_EQ(unit(0.01), "s");
  EXPECT_EQ(unit(1.0), "s");
  EXPECT_EQ(unit(10.0), "ms");
  EXPECT_EQ(unit(2500.0), "us");
  EXPECT_EQ(unit(1e7), "ns");
  const GuessedLog log = guess("time,y", [](int k) { return row({10.0 * k, std::sin(0.1 * k)}); });
  EXPECT_THAT(log.clock.why, HasSubstr("CHECK the unit: with steps of 10, the log has 100 rows per second in ms"));
}

TEST_F(LogGuess, IgnoresEmptyColumnsAndSaysWhy) {
  const GuessedLog log = guess("index,time,y_measured,y,dead,copy,note", [](int k) {
    return row({1.0 * k, 0.01 * k, std::sin(0.1 * k) + 0.1 * (k % 3), std::sin(0.1 * k), 7.0,
                std::sin(0.1 * k) + 0.1 * (k % 3)}) +
           ",ok";
  });
  EXPECT_EQ(log.clock.heading, "time");
  EXPECT_EQ(column(log, "y_measured").role, ColumnRole::kOutput);
  for (const char* name : {"index", "y", "dead", "copy", "note"}) {
    EXPECT_EQ(column(log, name).role, ColumnRole::kIgnored) << name;
    EXPECT_FALSE(column(log, name).why.empty());
  }
  EXPECT_THAT(column(log, "dead").why, HasSubstr("all its values are equal"));
  EXPECT_THAT(column(log, "copy").why, HasSubstr("a copy of \"y_measured\""));
  EXPECT_THAT(column(log, "note").why, HasSubstr("not numbers: \"ok\""));
}

TEST_F(LogGuess, UsesRowsAsTheClockOnlyIfTheirPeriodIsGiven) {
  const auto cells = [](int k) { return row({std::sin(0.1 * k), std::cos(0.1 * k)}); };
  EXPECT_EQ(guess("y,x1", cells).clock.period_s, 0.0);
  EXPECT_EQ(guess("y,x1", cells, {{}, {}, {}, 0.005}).clock.period_s, 0.005);
  const GuessedLog stuck = guess("time,y", [](int k) { return row({std::floor(0.1 * k), std::sin(0.1 * k)}); });
  EXPECT_EQ(stuck.clock.heading, "");
  EXPECT_THAT(stuck.notes, ElementsAre(HasSubstr("the clock is too coarse")));
}

TEST_F(LogGuess, SplitsByFilesAndLeavesCopiesOut) {
  std::vector<std::string> files;
  const auto cells = [](double phase) { return [phase](int k) { return row({0.01 * k, std::sin(0.1 * k + phase)}); }; };
  const auto split = [&](int count) {
    files.clear();
    for (int i = 0; i < count; ++i)
      files.push_back(write("set/run" + std::to_string(10 + i) + ".csv", "time,y", cells(0.1 * i), 20));
    return guess_log(files, {});
  };
  EXPECT_THAT(split(1).train, ElementsAre("run10.csv"));
  EXPECT_THAT(split(1).validation, IsEmpty());
  EXPECT_THAT(split(2).validation, ElementsAre("run11.csv"));
  const GuessedLog four = split(4);
  EXPECT_THAT(four.train, ElementsAre("run10.csv", "run11.csv"));
  EXPECT_THAT(four.validation, ElementsAre("run12.csv"));
  EXPECT_THAT(four.test, ElementsAre("run13.csv"));
  EXPECT_EQ(four.directory, folder_.path("set"));
  const GuessedLog ten = split(10);
  EXPECT_THAT(ten.validation, ElementsAre("run12.csv", "run17.csv"));
  EXPECT_THAT(ten.test, ElementsAre("run14.csv", "run19.csv"));
  EXPECT_EQ(ten.train.size(), 6U);
  files = {files[0], write("set/zcopy.csv", "time,y", cells(0.0), 20)};
  const GuessedLog copied = guess_log(files, {});
  EXPECT_THAT(copied.validation, IsEmpty());
  EXPECT_THAT(copied.notes, ElementsAre(HasSubstr("a copy of")));
}

TEST_F(LogGuess, SplitsByNamesThatSayIt) {
  const auto written = [&](const std::vector<std::string>& names) {
    std::vector<std::string> files;
    for (const std::string& name : names) {
      const double phase = 0.1 * static_cast<double>(files.size());
      files.push_back(write(
          name, "time,y",
          [phase](int k) {
            return row({0.01 * k, std::sin(0.1 * k + phase)});
          },
          20));
    }
    return guess_log(files, {});
  };
  const GuessedLog pair = written({"a/test_val.csv", "a/train_est.csv"});
  EXPECT_THAT(pair.train, ElementsAre("train_est.csv")) << "not the first of the alphabet";
  EXPECT_THAT(pair.test, ElementsAre("test_val.csv"));
  EXPECT_THAT(pair.validation, IsEmpty());
  const GuessedLog folders = written({"b/val/run1.csv", "b/drive/run2.csv", "b/drive/run3.csv"});
  EXPECT_THAT(folders.train, ElementsAre("drive/run2.csv", "drive/run3.csv"));
  EXPECT_THAT(folders.validation, ElementsAre("val/run1.csv"));
  const GuessedLog rest = written({"e/test.csv", "e/train_1.csv", "e/train_2.csv", "e/train_3.csv"});
  EXPECT_THAT(rest.train, ElementsAre("train_1.csv", "train_2.csv"));
  EXPECT_THAT(rest.validation, ElementsAre("train_3.csv")) << "the test judges, and must not choose the model";
  EXPECT_THAT(rest.test, ElementsAre("test.csv"));
  EXPECT_THAT(written({"c/latest1.csv", "c/latest2.csv"}).train, ElementsAre("latest1.csv")) << "not a word";
  EXPECT_THAT(written({"d/test1.csv", "d/test2.csv"}).train, ElementsAre("test1.csv")) << "one must train";
}

TEST_F(LogGuess, ReadsOtherSeparatorsAndDecimals) {
  const GuessedLog log =
      guess("time;y", [](int k) { return fmt_comma(0.01 * k) + ";" + fmt_comma(std::sin(0.1 * k)); });
  EXPECT_EQ(log.format.separator, ';');
  EXPECT_EQ(log.format.decimal, ',');
  EXPECT_NEAR(log.clock.period_s, 0.01, 1e-9);
  EXPECT_NEAR(column(log, "y").high, 1.0, 1e-2);
}

struct Row {
  const char *heading, *name, *unit;
};

TEST(Heading, SplitsAHeadingIntoNameAndUnit) {
  for (const Row& row : std::vector<Row>{{"height_m", "height", "m"},
                                         {"gyro x [rad/s]", "gyro_x", "rad/s"},
                                         {"temp (degC)", "temp", "degC"},
                                         {"Temp (°C)", "temp", "degC"},
                                         {"baro_hpa", "baro", "hPa"},
                                         {"wheelSpeed_m_s", "wheel_speed", "m/s"},
                                         {"acc_mps2", "acc", "m/s^2"},
                                         {"omega_dps", "omega", "deg/s"},
                                         {"current_a", "current", "A"},
                                         {"thrust %", "thrust", ""},
                                         {"thrust_pct", "thrust", "%"},
                                         {"time_ms", "time", "ms"},
                                         {"angle", "angle", ""},
                                         {"m", "m", ""},
                                         {"x (-)", "x", ""}}) {
    const Heading heading = read_heading(row.heading, {row.heading});
    EXPECT_EQ(heading.name, row.name) << row.heading;
    EXPECT_EQ(heading.unit, row.unit) << row.heading;
  }
}

TEST(Heading, DoesNotReadTheLetterOfOneOfSeveralPhasesAsAUnit) {
  EXPECT_EQ(read_heading("phase_a", {"phase_a", "phase_b"}).unit, "");
  EXPECT_EQ(read_heading("phase_a", {"phase_a", "phase_b"}).name, "phase_a");
  EXPECT_EQ(read_heading("phase_a", {"phase_a"}).unit, "A");
}

TEST(Heading, MakesAnIdentifierOfAnything) {
  for (const char* heading : {"", "2nd sensor", "while", "größe", "__", "a  -  b", "[m]", "class_m"})
    EXPECT_TRUE(codegen::is_identifier(read_heading(heading, {heading}).name))
        << heading << ": " << read_heading(heading, {heading}).name;
}

void expect(const char* text, char separator, char decimal) {
  const CsvFormat format = guess_csv_format(text);
  EXPECT_EQ(format.separator, separator) << text;
  EXPECT_EQ(format.decimal, decimal) << text;
}

TEST(CsvFormatGuess, FindsSeparatorAndDecimalMark) {
  expect("t,x\n0,1.5\n1,2.5\n", ',', '.');
  expect("t;x\n0;1.5\n1;2.5\n", ';', '.');
  expect("t;x\n0,0;1,5\n0,1;2,5\n", ';', ',');
  expect("t;x\n0;1\n1;2\n", ';', '.');
  expect("t\tx\n0\t1,5\n1\t-2,5e-3\n", '\t', ',');
  expect("t x y\n0 1.5 2\n1   2.5 3\n", ' ', '.');
  expect("# recorded: a; b, c\nt;x\n0;1,5\n", ';', ',');
  expect("Logger 2.1\nDate: 20,11\n\nt;x\n0;1,5\n1;2,5\n", ';', ',');
  expect("t;x\r0,0;1,5\r0,1;2,5\r", ';', ',');
  expect("t;x\n10:11:12.5;1,5\n10:11:12.6;2,5\n", ';', ',');
}

TEST(CsvFormatGuess, LeavesFilesWithoutATableToTheReader) {
  expect("", ',', '.');
  expect("x\n1\n2\n", ',', '.');
  expect("\"a;b\",c\n1,2\n", ',', '.');           // quotes hold a separator
  expect("gyro x,gyro y\n1,2\n3,4\n", ',', '.');  // blanks in headings separate nothing
  expect("t;x\n0;1,5\n1;2.5\n", ';', '.');        // both decimals occur: the reader reports the error
}

}  // namespace
}  // namespace nlo::trainer
