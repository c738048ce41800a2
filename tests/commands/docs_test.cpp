// SPDX-License-Identifier: MIT
// What the pages for users tell to do is what the program takes. tests/properties/pages.py follows their links.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <sstream>

#include "tests/commands/program.h"

namespace nlo::trainer {
namespace {

std::string page(const std::string& file) {
  std::ifstream stream(NLO_SOURCE_DIR "/" + file);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

/// What is between `from` and the next `to`.
std::string between(const std::string& text, const std::string& from, const std::string& to) {
  const auto start = text.find(from);
  const auto end = start == std::string::npos ? start : text.find(to, start + from.size());
  return end == std::string::npos ? "" : text.substr(start + from.size(), end - start - from.size());
}

TEST(Docs, TheWorkedChoiceTrainsWithEachOfItsSettings) {
  const std::string text = page("docs/choosing.md");
  const Scratch scratch;
  const std::string experiment = between(text, "```toml\n", "```");
  ASSERT_NE(experiment, "");
  scratch.write("pendulum.toml", experiment);
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
  EXPECT_GE(rows, 10) << "the table was not understood";
}

}  // namespace
}  // namespace nlo::trainer
