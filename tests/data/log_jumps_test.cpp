// SPDX-License-Identifier: MIT
// Each kind of jump that a log should not have, and jumps that belong to the plant.
#include "trainer/data/log_jumps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "tests/data/data_testing.h"

namespace nlo::trainer {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

using Column = std::function<double(int)>;

class LogJumps : public ::testing::Test {
 protected:
  /// Loads 2000 rows at 100 Hz: an output y that swings, and states with these headings. Returns the notes.
  std::vector<std::string> notes(const std::vector<std::string>& headings, const std::vector<Column>& states,
                                 const std::string& unit = "") {
    LogConfig config;
    config.columns = {column("time", ColumnRole::kTime, {.unit = "s"}), column("y", ColumnRole::kOutput)};
    std::string text = "time,y";
    for (const std::string& heading : headings) {
      config.columns.push_back(column(heading, ColumnRole::kState, {.unit = unit}));
      text += "," + heading;
    }
    for (int k = 0; k < 2000; ++k) {
      char cell[40];
      std::snprintf(cell, sizeof cell, "\n%.3f,%.7g", 0.01 * k, std::sin(0.031 * k) + 0.3 * std::sin(0.17 * k));
      text += cell;
      for (const Column& state : states) {
        std::snprintf(cell, sizeof cell, ",%.7g", state(k));
        text += cell;
      }
    }
    scratch_.write("log.csv", text + "\n");
    LogReport report;
    load_logs(config, scratch_.path(), {"log.csv"}, &report);
    return report.notes;
  }

  ScratchDirectory scratch_;
};

double course(int k) {
  return 0.01 * k + 0.8 * std::sin(0.02 * k);
}
/// -1 in rows 300 to 699 and 1500 to 1799, else 1.
double side(int k) {
  return (k >= 300 && k < 700) || (k >= 1500 && k < 1800) ? -1.0 : 1.0;
}

TEST_F(LogJumps, InTheSignOfAQuaternionAreNotedOnceWithTheRemedy) {
  const Column w = [](int k) { return side(k) * std::cos(0.5 * course(k)); },
               z = [](int k) { return side(k) * std::sin(0.5 * course(k)); };
  EXPECT_THAT(notes({"a", "b"}, {w, z}),
              ElementsAre(AllOf(HasSubstr("log.csv:302: \"a\" and \"b\" change the sign, "), HasSubstr("(4 such rows)"),
                                HasSubstr("use elements of its rotation matrix instead, in the log: 1"))));
  EXPECT_THAT(notes({"q_w"}, {w}), ElementsAre(HasSubstr("\"q_w\" changes the sign"))) << "its heading is enough";
  EXPECT_THAT(notes({"a", "b"}, {[&](int k) { return side(k) * w(k); }, [&](int k) { return side(k) * z(k); }}),
              IsEmpty())
      << "control";
}

TEST_F(LogJumps, InAPositiveQuaternionAreNotReportedAsAWrap) {
  const auto canonical = [](int k) { return std::cos(0.5 * course(k)) < 0.0 ? -1.0 : 1.0; };
  EXPECT_THAT(notes({"w", "z"}, {[&](int k) { return canonical(k) * std::cos(0.5 * course(k)); },
                                 [&](int k) { return canonical(k) * std::sin(0.5 * course(k)); }}),
              ElementsAre(AllOf(HasSubstr("\"z\" changes the sign, "), HasSubstr("quaternion"))));
}

TEST_F(LogJumps, InAnAngleAreNotedWithItsFullTurn) {
  const auto wrapped = [](double turn, double low) {
    return [=](int k) { return low + std::fmod(turn * (0.31 + 0.004 * k + 0.02 * std::sin(0.05 * k)), turn); };
  };
  EXPECT_THAT(notes({"a"}, {wrapped(kTurn, -0.5 * kTurn)}),
              ElementsAre(AllOf(HasSubstr("log.csv:"), HasSubstr("\"a\" jumps from 3.1"), HasSubstr("(8 such rows)"),
                                HasSubstr("write wrap = \"2pi\" and encoding = \"sincos\" at the column"))));
  EXPECT_THAT(notes({"a"}, {wrapped(360.0, 0.0)}), ElementsAre(HasSubstr("wrap = 360 ")));
  EXPECT_THAT(notes({"a"}, {wrapped(1.0, 0.0)}), ElementsAre(HasSubstr("wrap = 1 ")));
  const auto counts = wrapped(4096.0, 0.0);
  EXPECT_THAT(notes({"a"}, {[&](int k) { return std::floor(counts(k)); }}), ElementsAre(HasSubstr("wrap = 4096 ")));
  EXPECT_THAT(notes({"a"}, {[](int k) { return k < 1000 ? 3.0 : -3.2; }}, "rad"),
              Contains(AllOf(HasSubstr("log.csv:1002: \"a\" jumps from 3 to -3.2: is it an angle that wraps?"))))
      << "with the unit of an angle, one jump is enough";
}

TEST_F(LogJumps, AreNotedIfColumnsChangePlaces) {
  const auto joint = [](int i, int k) { return 0.7 * i + 0.5 + 0.3 * std::sin(0.01 * (i + 2) * k + i); };
  const auto swaps = [&](int i, int k) { return joint(k % 300 > 200 && i < 2 ? 1 - i : i, k); };
  const auto turns = [&](int i, int k) { return joint(k % 300 > 200 ? (i + 1) % 3 : i, k); };
  const auto every_row = [&](int i, int k) { return joint(k % 2 == 1 && i < 2 ? 1 - i : i, k); };
  const auto columns = [](const std::function<double(int, int)>& f) {
    return std::vector<Column>{[=](int k) { return f(0, k); }, [=](int k) { return f(1, k); },
                               [=](int k) { return f(2, k); }};
  };
  const std::vector<std::string> names = {"a", "b", "c"};
  EXPECT_THAT(notes(names, columns(swaps)),
              ElementsAre(AllOf(HasSubstr("log.csv:203: \"a\" and \"b\" change places (12 "
                                          "such rows)"),
                                HasSubstr("under its own name"))));
  EXPECT_THAT(notes(names, columns(turns)), ElementsAre(HasSubstr("\"a\", \"b\" and \"c\" change places")));
  EXPECT_THAT(notes(names, columns(every_row)),
              ElementsAre(HasSubstr("\"a\" and \"b\" change places (1999 such rows)")));
  EXPECT_THAT(notes(names, columns(joint)), IsEmpty()) << "control";
}

TEST_F(LogJumps, ThatThePlantMakesAreNotReported) {
  std::mt19937 engine(3);
  std::normal_distribution<double> noise(0.0, 1.0);
  const auto square = [](int k) { return k % 100 < 50 ? 1.0 : -1.0; };
  const auto noisy = [&](const Column& of) {
    return [&engine, &noise, of](int k) { return of(k) + 0.02 * noise(engine); };
  };
  const std::vector<std::pair<const char*, std::vector<Column>>> plants = {
      {"square waves", {square, [&](int k) { return -square(k); }}},
      {"noisy square waves", {noisy(square), noisy([&](int k) { return -square(k); })}},
      {"valves, one of them open",
       {noisy([&](int k) { return square(k) > 0; }), noisy([&](int k) { return square(k) < 0; })}},
      {"noise", {[&](int) { return noise(engine); }, [&](int) { return noise(engine); }}},
      {"friction",
       {[](int k) {
          const double v = std::sin(0.05 * k);
          return (v > 0 ? 1.0 : -1.0) * 0.5 + 0.4 * v;
        },
        [](int k) { return std::sin(0.05 * k); }}},
      {"a ball's velocity and height",
       {[](int k) { return 1.0 - 0.02 * (k % 100); },
        [](int k) { return 0.01 * (k % 100) * (1.0 - 0.01 * (k % 100)); }}},
      {"commutation",
       {[&](int k) { return k % 60 < 30 ? 2.0 + std::sin(0.01 * k) : 0.0; },
        [&](int k) { return k % 60 < 30 ? 0.0 : 2.0 + std::sin(0.01 * k); }}},
      {"steps to any level",
       {[](int k) { return std::sin(1.7 * (k / 70)); }, [](int k) { return std::sin(2.9 * (k / 70)); }}},
      {"a counter that is reset at any time",
       {[](int k) { return k < 250    ? 0.01 * k
                           : k < 1400 ? 0.01 * (k - 250)
                                      : 0.01 * (k - 1400); },
        [](int k) { return std::cos(0.01 * k); }}},
  };
  for (const auto& [what, states] : plants)
    for (const std::string& note : notes({"a", "b"}, states)) {
      EXPECT_THAT(note, Not(HasSubstr("change the sign"))) << what;
      EXPECT_THAT(note, Not(HasSubstr("changes the sign"))) << what;
      EXPECT_THAT(note, Not(HasSubstr("wraps?"))) << what;
      EXPECT_THAT(note, Not(HasSubstr("change places"))) << what;
    }
}

}  // namespace
}  // namespace nlo::trainer
