// SPDX-License-Identifier: MIT
// What the program prints about its own command line: the script that completes it in bash, and the manual page.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <sstream>

#include "tests/commands/program.h"

namespace nlo::trainer {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsSupersetOf;
using testing::Not;

/// What a shell prints; `status` is its exit status.
std::string shell(const std::string& command, int* status = nullptr) {
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return "";
  std::string text;
  std::array<char, 4096> part{};
  for (std::size_t n = 0; (n = std::fread(part.data(), 1, part.size(), pipe)) > 0;) text.append(part.data(), n);
  const int ended = ::pclose(pipe);
  if (status != nullptr) *status = ended;
  return text;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// What bash offers at the end of `words`, in a folder with model.json, mine.toml and logs/.
std::vector<std::string> offered(const std::vector<std::string>& words) {
  const Scratch scratch;
  scratch.write("model.json", "");
  scratch.write("mine.toml", "");
  scratch.write("logs/a.csv", "");
  scratch.write("complete.sh", scratch.run({"completion", "bash"}).out);
  std::string command = "cd '" + scratch.path() + "' && bash --norc -c 'source ./complete.sh && COMP_WORDS=(nlo";
  for (const std::string& word : words) command += word.empty() ? " \"\"" : " " + word;
  command +=
      ") && COMP_CWORD=" + std::to_string(words.size()) + " && _nlo && printf \"%s\\n\" \"${COMPREPLY[@]}\"' 2>&1";
  return lines_of(shell(command));
}

TEST(BashCompletion, OffersCommandsOptionsAndTheirValues) {
  if (shell("command -v bash").empty()) GTEST_SKIP() << "bash is not installed";
  EXPECT_THAT(offered({""}), IsSupersetOf({"train", "evaluate", "export", "completion", "man"}));
  EXPECT_THAT(offered({"ev"}), testing::ElementsAre("evaluate"));
  EXPECT_THAT(offered({"--v"}), testing::ElementsAre("--version"));
  EXPECT_THAT(offered({"evaluate", "--b"}), testing::ElementsAre("--box-scale"));
  EXPECT_THAT(offered({"evaluate", "model.json", "--against", ""}), IsSupersetOf({"ekf", "constant"}));
  EXPECT_THAT(offered({"export", "--target", "a"}), testing::ElementsAre("arduino"));
  EXPECT_THAT(offered({"reproduce", "table1"}), Contains("table1"));
  EXPECT_THAT(offered({"completion", ""}), testing::ElementsAre("bash"));
}

TEST(BashCompletion, OffersExperimentsAndFiles) {
  if (shell("command -v bash").empty()) GTEST_SKIP() << "bash is not installed";
  EXPECT_THAT(offered({"train", ""}), IsSupersetOf({"mine.toml", "logs", "van_der_pol", "qube"}));
  EXPECT_THAT(offered({"train", ""}), Not(Contains("model.json")));
  EXPECT_THAT(offered({"evaluate", ""}), Contains("model.json"));
  EXPECT_THAT(offered({"evaluate", ""}), Not(Contains("mine.toml")));
  EXPECT_THAT(offered({"train", "qube", "--data", ""}), testing::ElementsAre("logs"));
}

TEST(BashCompletion, KnowsEveryOptionOfTheHelp) {
  const Scratch scratch;
  const std::string script = scratch.run({"completion", "bash"}).out;
  int options = 0;
  for (const char* command :
       {"train", "evaluate", "crossvalidate", "bound", "export", "report", "reproduce", "simulate"}) {
    const auto at = script.find(std::string("      '") + command + "')");
    ASSERT_NE(at, std::string::npos) << command;
    const std::string listed = script.substr(at, script.find('\n', at) - at);
    std::istringstream help(scratch.run({command, "--help"}).out);
    for (std::string word; help >> word;) {
      const auto dashes = word.find("--");
      if (word.front() != '-' || dashes == std::string::npos || word == "--") continue;
      const auto end = word.find_first_not_of("abcdefghijklmnopqrstuvwxyz-", dashes);  // as in "(1 with --quick)"
      EXPECT_THAT(listed, HasSubstr(word.substr(dashes, end - dashes))) << command;
      ++options;
    }
  }
  EXPECT_GT(options, 40) << "the help was not understood, so this test proves nothing";
}

TEST(ManPage, HasEveryCommandAndNoComplaintOfGroff) {
  const Scratch scratch;
  const std::string page = scratch.run({"man"}).out;
  EXPECT_THAT(page, HasSubstr(".TH NLO 1"));
  for (const char* command :
       {"train", "evaluate", "crossvalidate", "bound", "export", "report", "reproduce", "simulate"})
    EXPECT_THAT(page, HasSubstr(std::string(".SS \\fBnlo ") + command)) << command;
  EXPECT_THAT(page, HasSubstr("\\fB\\-\\-box\\-scale\\fR"));
  EXPECT_THAT(page, HasSubstr("(default: 200)"));
  if (shell("command -v groff").empty()) GTEST_SKIP() << "groff is not installed";
  scratch.write("nlo.1", page);
  scratch.write("broken.1", page + ".nosuchrequest\n\\fQ text\n");
  const auto complaints = [&](const char* file) {
    return shell("groff -man -Tutf8 -ww -z '" + scratch.path() + "/" + file + "' 2>&1");
  };
  EXPECT_EQ(complaints("nlo.1"), "");
  EXPECT_NE(complaints("broken.1"), "");  // control
  const std::string text = shell("groff -man -Tascii -P-c '" + scratch.path() + "/nlo.1' 2>/dev/null");
  EXPECT_THAT(text, HasSubstr("nlo export model.json --target replay -o van_der_pol_replay.h"));
  EXPECT_THAT(text, Not(HasSubstr("\\f")));
}

TEST(Program, CompletesOnlyForShellsThatItKnows) {
  const Scratch scratch;
  const auto result = scratch.run({"completion", "fish"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("bash"));
  EXPECT_EQ(scratch.run({"completion"}).exit_code, 2);
}

}  // namespace
}  // namespace nlo::trainer
