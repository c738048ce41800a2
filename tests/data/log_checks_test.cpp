// SPDX-License-Identifier: MIT
// Each warning about a log appears for a log with the fault, and not for a log that almost has it.
#include "trainer/data/log_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "tests/data/data_testing.h"
#include "trainer/data/log_dataset.h"
#include "trainer/data/log_outliers.h"
#include "trainer/data/logged_velocity.h"

namespace nlo::trainer {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kPeriod_s = 0.01;
constexpr double kDegree = kTurn / 360.0;

/// 6 s of a(t) and b(t) at 100 Hz.
std::string two_columns(const std::function<double(double)>& a, const std::function<double(double)>& b) {
  std::string text = "time,a,b\n";
  for (int k = 0; k < 600; ++k) {
    char row[80];
    std::snprintf(row, sizeof row, "%.3f,%.7g,%.7g\n", kPeriod_s * k, a(kPeriod_s * k), b(kPeriod_s * k));
    text += row;
  }
  return text;
}

double swing(double t) {
  return 1.3 * std::sin(3.0 * t) * std::exp(-0.1 * t);
}
double swing_rate(double t) {
  return 1.3 * std::exp(-0.1 * t) * (3.0 * std::cos(3.0 * t) - 0.1 * std::sin(3.0 * t));
}
double other(double t) {
  return std::cos(1.7 * t) + 0.4 * std::sin(5.0 * t);
}

class LogChecks : public ::testing::Test {
 protected:
  /// Loads a log with output `a` and state `b` and returns its notes.
  std::vector<std::string> notes(const std::string& csv, const ColumnOptions& a = {}, const ColumnOptions& b = {}) {
    LogConfig config;
    config.columns = {column("time", ColumnRole::kTime, {.unit = time_unit_}), column("a", ColumnRole::kOutput, a),
                      column("b", ColumnRole::kState, b)};
    scratch_.write("log.csv", csv);
    LogReport report;
    load_logs(config, scratch_.path(), {"log.csv"}, &report);
    return report.notes;
  }

  ScratchDirectory scratch_;
  std::string time_unit_;
};

TEST_F(LogChecks, NoteAConstantColumn) {
  EXPECT_THAT(notes(two_columns([](double) { return 0.25; }, other)),
              ElementsAre(AllOf(HasSubstr("\"a\" is 0.25 in every row"), HasSubstr("leave it out"))));
  EXPECT_THAT(notes(two_columns([](double t) { return t < 5.9 ? 0.25 : 0.26; }, other)), IsEmpty());
}

TEST_F(LogChecks, NoteACopiedColumn) {
  EXPECT_THAT(notes(two_columns(swing, swing)), ElementsAre(HasSubstr("\"a\" and \"b\" contain the same signal, ")));
  EXPECT_THAT(notes(two_columns(swing, [](double t) { return 3.0 - 2.0 * swing(t); })),
              ElementsAre(HasSubstr("the second is -2 times the first, +3")));
  std::mt19937 engine(1);  // control: a second sensor with 1 % of noise
  std::normal_distribution<double> noise(0.0, 0.01);
  EXPECT_THAT(notes(two_columns(swing, [&](double t) { return swing(t) + noise(engine); })), IsEmpty());
}

TEST_F(LogChecks, NoteDegreesInAColumnOfRad) {
  const auto degrees = [](double t) { return swing(t) / kDegree; };  // up to 74 degrees
  EXPECT_THAT(
      notes(two_columns(degrees, other), {.unit = "rad"}),
      ElementsAre(AllOf(HasSubstr("is it in degrees although its unit is rad?"), HasSubstr("set unit to deg"))));
  EXPECT_THAT(notes(two_columns(degrees, other), {.unit = "deg"}), IsEmpty());
  EXPECT_THAT(notes(two_columns([](double t) { return 8.0 * swing(t); }, other), {.unit = "rad"}), IsEmpty());
  // A wrap in the wrong unit: jumps of 360 show it.
  const auto wrapped = [](double t) { return std::remainder(3.0 * swing(t) / kDegree, 360.0); };
  EXPECT_THAT(notes(two_columns(wrapped, other), {.unit = "rad", .wrap = kTurn}),
              Contains(AllOf(HasSubstr("and jumps by 360: is it in degrees"), HasSubstr("unit and wrap"))));
}

TEST_F(LogChecks, NoteRadInAColumnOfDegrees) {
  const auto wrapped = [](double t) { return std::remainder(3.0 * swing(t), kTurn); };
  EXPECT_THAT(notes(two_columns(wrapped, other), {.unit = "deg", .wrap = 360.0}),
              ElementsAre(AllOf(HasSubstr("and jumps by 2 pi: is it in rad although its unit is degrees?"),
                                HasSubstr("to rad"))));
  EXPECT_THAT(notes(two_columns(swing, other), {.unit = "deg"}), IsEmpty());  // a range of a few degrees is plausible
}

TEST_F(LogChecks, NoteAnAngleThatNeverReachesItsWrap) {
  EXPECT_THAT(notes(two_columns(swing, other), {.unit = "rad", .wrap = kTurn}),
              ElementsAre(AllOf(HasSubstr("\"a\" never wraps"), HasSubstr("remove wrap"))));
  // The angle does not wrap in this log, but it comes so close to the wrap that another log may wrap.
  EXPECT_THAT(notes(two_columns([](double t) { return 2.0 * swing(t); }, other), {.unit = "rad", .wrap = kTurn}),
              IsEmpty());
}

TEST_F(LogChecks, NoteAnAngleThatCrossesItsWrapTooOften) {
  const auto spin = [](double per_second) {
    return two_columns([=](double t) { return std::remainder(per_second * t, kTurn); }, other);
  };
  EXPECT_THAT(notes(spin(370.0), {.unit = "rad", .wrap = kTurn}),
              Contains(AllOf(HasSubstr("\"a\" crosses its wrap in"), HasSubstr("check unit and wrap"))));
  EXPECT_THAT(notes(spin(150.0), {.unit = "rad", .wrap = kTurn}), IsEmpty());  // once in four steps is accepted
}

TEST_F(LogChecks, NoteALoggedVelocityThatLags) {
  double rate = 0.0, last = swing(0.0);
  const auto logged = [&](double t) {  // a filtered difference, as on many rigs
    rate = 0.8 * rate + 0.2 * (swing(t) - last) / kPeriod_s;
    last = swing(t);
    return rate;
  };
  // Lag of 0.8 / 0.2 samples from the low-pass and half a sample from the difference.
  EXPECT_THAT(notes(two_columns(swing, logged)),
              ElementsAre(AllOf(HasSubstr("log.csv: "), HasSubstr("\"b\" is the velocity of \"a\", 4.5 samples late"),
                                HasSubstr("derivative_of = \"a\""))));
  EXPECT_THAT(notes(two_columns(swing, swing_rate)), IsEmpty());
  EXPECT_THAT(notes(two_columns(swing, other)), IsEmpty());
}

/// Returns other(t), except for the value `off` in some rows from 3 s on.
std::function<double(double)> stray(int rows, double off) {
  return [=](double t) { return other(t) + (t > 2.995 && t < 2.995 + kPeriod_s * rows ? off : 0.0); };
}

TEST_F(LogChecks, NoteOutliersOfAState) {
  EXPECT_THAT(
      notes(two_columns(swing, stray(2, 8.0)), {}, {.unit = "m/s"}),
      ElementsAre(
          AllOf(HasSubstr("log.csv:303: \"b\" is 8.638 m/s, but 0.6372 before and 0.6377 after (the farthest of 2 such "
                          "rows): an outlier"),
                HasSubstr("leave the cell empty"))));
  EXPECT_THAT(notes(two_columns(swing, stray(1, -8.0))), ElementsAre(HasSubstr("an outlier")));
  EXPECT_THAT(notes(two_columns(swing, stray(int(kOutlierRows), 8.0))), ElementsAre(HasSubstr("of 5 such rows")));
  // Not reported: an output, a small deviation, a lasting change.
  EXPECT_THAT(notes(two_columns(stray(2, 8.0), swing)), IsEmpty());
  EXPECT_THAT(notes(two_columns(swing, stray(2, 1.0))), IsEmpty());
  EXPECT_THAT(notes(two_columns(swing, stray(int(kOutlierRows) + 1, 8.0))), IsEmpty());
}

TEST_F(LogChecks, NoteNoOutliersOfOrdinaryStates) {
  std::mt19937 engine(3);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::exponential_distribution<double> tail(1.0);
  int k = 0;
  const std::vector<std::function<double(double)>> states = {
      [&](double) { return noise(engine); },
      [&](double) { return tail(engine) - tail(engine); },             // heavier tails
      [](double t) { return std::fmod(t, 0.5) < 0.25 ? 1.0 : -1.0; },  // a square wave
      [](double t) {
        return std::fmod(t, 2.0) < 0.1 ? std::sin(31.4 * t) : 0.0;
      },                                                       // at rest except for bursts of ten rows
      [](double t) { return std::floor(3.0 * std::sin(t)); },  // coarse resolution
      [](double t) { return std::exp(3.0 * t); },              // most of the motion at the end
      [&](double) { return k++ % 100 == 0 ? 1.0 : 0.0; },      // a flag
  };
  for (std::size_t i = 0; i < states.size(); ++i)
    for (const std::string& note : notes(two_columns(swing, states[i])))
      EXPECT_EQ(note.find("an outlier"), std::string::npos) << i << ": " << note;
}

TEST_F(LogChecks, NoteStampsThatLookLikeMilliseconds) {
  const auto log = [](double step, int rows, double start = 0.0) {
    std::string text = "time,a,b\n";
    for (int k = 0; k < rows; ++k) {
      char row[100];
      std::snprintf(row, sizeof row, "%.15g,%.7g,%.7g\n", start + step * k, swing(0.01 * k), other(0.01 * k));
      text += row;
    }
    return text;
  };
  EXPECT_THAT(
      notes(log(10, 600)),
      ElementsAre(
          "\"time\" has no unit and is read in s, which gives a row every 10 s: if its stamps are in ms, set unit = "
          "\"ms\" at the column with role = \"time\"; if they are in s, set unit = \"s\""));
  EXPECT_THAT(notes(log(1e4, 600)), ElementsAre(HasSubstr("set unit = \"us\"")));
  EXPECT_THAT(notes(log(1e7, 600)), ElementsAre(HasSubstr("set unit = \"ns\"")));
  time_unit_ = "s";  // a declared unit is accepted: batteries and ovens are logged once a second
  EXPECT_THAT(notes(log(10, 600)), IsEmpty());
  EXPECT_THAT(notes(log(10, 600, 1.7e12)),
              ElementsAre(AllOf(HasSubstr("beyond the year 5000"), HasSubstr("unit = \"ms\""))));
  EXPECT_THAT(notes(log(0.01, 600, 1.7e9)), IsEmpty());
  time_unit_ = "ms";
  EXPECT_THAT(notes(log(10, 600, 1.7e12)), IsEmpty());
  EXPECT_THAT(notes(log(1e4, 600, 1.7e15)), ElementsAre(HasSubstr("unit = \"us\"")));
  time_unit_ = "";
  EXPECT_THAT(notes(log(0.01, 600)), IsEmpty());
  EXPECT_THAT(notes(log(10, 199)), IsEmpty());  // a log of a hundred rows may be written by hand
}

TEST_F(LogChecks, ErrorOfAVelocityThatCannotBeFilteredNamesTheUnitOfTheTime) {
  LogConfig config;
  config.columns = {column("time", ColumnRole::kTime), column("a", ColumnRole::kOutput),
                    column("b", ColumnRole::kState, {.derivative_of = "a"})};
  std::string csv = "time,a\n";
  for (int k = 0; k < 300; ++k) csv += std::to_string(4 * k) + "," + std::to_string(swing(0.004 * k)) + "\n";
  scratch_.write("log.csv", csv);
  const auto load = [&] { load_logs(config, scratch_.path(), {"log.csv"}); };
  EXPECT_THAT(thrown_message(load),
              AllOf(HasSubstr("cut"), HasSubstr("set unit = \"ms\" at the column with role = \"time\"")));
  config.columns[0].unit = "ms";
  EXPECT_EQ(thrown_message(load), "no error");  // control
}

TEST_F(LogChecks, NoteALoggedVelocityThatIsADifference) {
  const auto difference = [](double t) { return (swing(t) - swing(t - kPeriod_s)) / kPeriod_s; };
  EXPECT_THAT(notes(two_columns(swing, difference)), ElementsAre(HasSubstr("0.5 samples late")));
}

TEST_F(LogChecks, NoteALoggedVelocityInAnotherUnit) {
  EXPECT_THAT(
      notes(two_columns(swing, [](double t) { return swing_rate(t) / kDegree; }), {.unit = "rad"}, {.unit = "rad/s"}),
      ElementsAre(HasSubstr("57.3 times as large, so it may be in degrees: check units")));
}

TEST(LoggedVelocity, LagIsExactToAFractionOfASample) {
  Eigen::VectorXd velocity(1000), late(1000);
  for (int k = 0; k < 1000; ++k) {
    velocity[k] = swing_rate(0.01 * k);
    late[k] = 0.5 * swing_rate(0.01 * (k - 3.3));
  }
  const auto match = match_velocity(late, velocity, 20);
  ASSERT_TRUE(match.has_value());
  EXPECT_NEAR(match->lag_samples, 3.3, 0.05);  // the damping within the lag is not a delay
  EXPECT_NEAR(match->gain, 0.5, 0.01);
  EXPECT_FALSE(match_velocity(late.head(100), velocity.head(100), 20).has_value());
  EXPECT_FALSE(match_velocity(Eigen::VectorXd::Ones(1000), velocity, 20).has_value());
}

TEST_F(LogChecks, NoteAPeriodThatDiffersFromThatOfTheStamps) {
  LogConfig config;
  config.columns = {column("time", ColumnRole::kTime), column("a", ColumnRole::kOutput),
                    column("b", ColumnRole::kState)};
  scratch_.write("log.csv", two_columns(swing, other));
  const auto load = [&](double period_s) {
    config.sample_period_s = period_s;
    LogReport report;
    const bool uniform = load_logs(config, scratch_.path(), {"log.csv"}, &report).uniform;
    EXPECT_EQ(uniform, report.notes.empty());
    return report.notes;
  };
  EXPECT_THAT(load(0.0102),
              ElementsAre(AllOf(HasSubstr("have the period 0.01 s"), HasSubstr("sample_period_s = 0.01"))));
  EXPECT_THAT(load(0.010005), IsEmpty());  // half a thousandth
}

}  // namespace
}  // namespace nlo::trainer
