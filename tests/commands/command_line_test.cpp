// SPDX-License-Identifier: MIT
// Help texts, and the commands that pages for users contain. tests/properties/pages.py checks the links of the pages.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <regex>
#include <sstream>

#include "tests/commands/program.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::Not;

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(Help, IsAsWideAsTheTerminal) {
  const Scratch scratch;
  const auto longest = [&](const char* columns) {
    EXPECT_EQ(setenv("COLUMNS", columns, 1), 0);
    std::size_t length = 0;
    for (const char* command : {"", "train", "evaluate", "compare", "export", "monitor"}) {
      const auto help = command[0] == '\0' ? scratch.run({"--help"}) : scratch.run({command, "--help"});
      for (const std::string& line : lines_of(help.out))
        if (!line.starts_with("  nlo ") &&
            line.find(' ', line.find_first_not_of(' ')) != std::string::npos)  // examples
          length = std::max(length, line.size());
    }
    EXPECT_EQ(unsetenv("COLUMNS"), 0);
    return length;
  };
  EXPECT_LE(longest("80"), 80U);
  EXPECT_GT(longest("160"), 120U) << "control: a wide terminal is used";
}

TEST(Help, StatesRangesAndChoicesInWords) {
  const Scratch scratch;
  const std::string help = scratch.run({"evaluate", "--help"}).out;
  EXPECT_THAT(help, HasSubstr("--trajectories INT=200 "));
  EXPECT_THAT(help, HasSubstr("1 to 100000"));
  EXPECT_THAT(help, Not(HasSubstr("INT:INT")));
}

std::string page(const std::string& file) {
  std::ifstream stream(NLO_SOURCE_DIR "/" + file);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

/// Returns the text between `from` and the next `to`.
std::string between(const std::string& text, const std::string& from, const std::string& to) {
  const auto start = text.find(from);
  const auto end = start == std::string::npos ? start : text.find(to, start + from.size());
  return end == std::string::npos ? "" : text.substr(start + from.size(), end - start - from.size());
}

TEST(Docs, EachSettingOfTheWorkedExampleTrains) {
  const std::string text = page("docs/choosing.md");
  const Scratch scratch;
  const std::string experiment = between(text, "```toml\nname", "```");
  ASSERT_NE(experiment, "");
  scratch.write("pendulum.toml", "name" + experiment);
  std::istringstream table(between(text, "| `--set` |", "| EKF"));
  const std::regex setting("`([a-z_]+\\.[a-z_]+=[^`]+)`");
  int rows = 0;
  for (std::string row; std::getline(table, row);) {
    std::vector<std::string> command = {"train", "pendulum.toml", "-o", "run", "-q"};
    for (std::sregex_iterator match(row.begin(), row.end(), setting), end; match != end; ++match)
      command.insert(command.end(), {"--set", (*match)[1]});
    if (command.size() == 5) continue;
    command.insert(command.end(), {"--set", "simulation.trajectories=2", "--set", "simulation.horizon_s=4", "--set",
                                   "training.steps=1"});
    const auto run = scratch.run(command);
    EXPECT_EQ(run.exit_code, 0) << row << "\n" << run.err;
    ++rows;
  }
  EXPECT_GE(rows, 10) << "the test did not find the rows of the table";
}

}  // namespace
}  // namespace nlo::trainer
