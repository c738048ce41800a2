// SPDX-License-Identifier: MIT
// The text of a log report for a terminal.
#include "trainer/data/log_report.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::Not;

std::vector<std::string> note_lines(const std::vector<std::string>& notes) {
  LogReport report;
  report.notes = notes;
  std::istringstream text(to_text(report));
  std::vector<std::string> lines;
  bool in_notes = false;
  for (std::string line; std::getline(text, line);) {
    in_notes = in_notes || line.starts_with("note:");
    if (in_notes) lines.push_back(line);
  }
  return lines;
}

TEST(LogReport, ShowsAllOfAFewShortNotes) {
  EXPECT_EQ(note_lines({"one is wrong: write a", "two is wrong: write b"}),
            (std::vector<std::string>{"note: one is wrong: write a", "note: two is wrong: write b"}));
}

TEST(LogReport, ShowsManyLongNotesInTwentyFiveLinesOf120ColumnsAndCountsTheRest) {
  std::vector<std::string> notes;
  for (int i = 0; i < 40; ++i) {
    std::string note = fmt::format("column {}", i);
    while (note.size() < 200) note += " jumps";
    notes.push_back(note);
  }
  const std::vector<std::string> lines = note_lines(notes);
  EXPECT_EQ(lines.size(), 25U);
  for (const std::string& line : lines) EXPECT_LE(line.size(), 120U) << line;
  EXPECT_THAT(lines.front(), HasSubstr("column 0"));
  EXPECT_EQ(lines.back(), "note: 28 more notes are in report.html");
}

TEST(LogReport, GivesAVeryLongWordItsOwnLine) {
  const std::string path(300, 'x');
  const std::vector<std::string> lines = note_lines({"the file " + path + " is empty"});
  EXPECT_EQ(lines.size(), 3U);
  EXPECT_THAT(lines[1], HasSubstr(path));
  EXPECT_THAT(lines[0], Not(HasSubstr("x")));
}

}  // namespace
}  // namespace nlo::trainer
