// SPDX-License-Identifier: MIT
// What the program prints about its own command line: scripts that complete it in bash and zsh, help,
// and the manual page.
// What the pages for users tell to do is what the program takes. tests/properties/pages.py follows their links.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <regex>
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
  EXPECT_THAT(offered({"evaluate", "--bo"}), testing::ElementsAre("--box-scale"));
  EXPECT_THAT(offered({"evaluate", "model.json", "--against", ""}), IsSupersetOf({"ekf", "constant"}));
  EXPECT_THAT(offered({"export", "--target", "a"}), testing::ElementsAre("arduino"));
  EXPECT_THAT(offered({"completion", ""}), testing::ElementsAre("bash", "zsh"));
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
       {"train", "evaluate", "crossvalidate", "bound", "dossier", "export", "report", "reproduce", "simulate"}) {
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

/// What zsh offers at the end of `line`, in a folder as above: a shell in a pseudo-terminal gets the line and a tab,
/// and says what its completions add.
std::vector<std::string> offered_by_zsh(const std::string& line) {
  const Scratch scratch;
  scratch.write("model.json", "");
  scratch.write("mine.toml", "");
  scratch.write("logs/a.csv", "");
  scratch.write("complete.sh", scratch.run({"completion", "zsh"}).out);
  scratch.write("inside.zsh", R"zsh(PROMPT= RPROMPT=
autoload -Uz compinit && compinit -u -D
source ./complete.sh
bindkey '^I' complete-word
zstyle ':completion:*' completer _complete
compadd() {
  if [[ ${@[1,(i)(-|--)]} == *-(O|A|D)\ * ]]; then builtin compadd "$@"; return; fi
  local -a hits
  builtin compadd -O hits "$@"
  for hit in $hits; do print -r -- "OFFERED:$hit"; done
  builtin compadd "$@"
}
finished() { print DONE }
comppostfuncs=(finished)
print READY
)zsh");
  scratch.write("outside.zsh", R"zsh(zmodload zsh/zpty || exit 1
zpty shell zsh -f -i
zpty -w shell "source ./inside.zsh"
line=
until [[ $line == *READY* ]]; do zpty -r shell line || exit 1; done
zpty -w -n shell "$1"$'\t'
until [[ $line == *DONE* ]]; do zpty -r shell line || break; print -rn -- $line; done
zpty -d shell
)zsh");
  const std::string said =
      shell("cd '" + scratch.path() + "' && timeout 30 zsh -f outside.zsh '" + line + "' 2>&1 | tr -d '\\r'");
  std::vector<std::string> words;
  const std::string mark = "OFFERED:";
  for (const std::string& each : lines_of(said))
    if (const auto at = each.find(mark); at != std::string::npos) words.push_back(each.substr(at + mark.size()));
  return words;
}

TEST(ZshCompletion, OffersCommandsOptionsAndTheirValues) {
  if (shell("command -v zsh").empty()) GTEST_SKIP() << "zsh is not installed";
  EXPECT_THAT(offered_by_zsh("nlo "), IsSupersetOf({"train", "evaluate", "export", "completion", "man"}));
  EXPECT_THAT(offered_by_zsh("nlo train --da"), testing::ElementsAre("--data"));
  EXPECT_THAT(offered_by_zsh("nlo evaluate model.json --against "),
              testing::UnorderedElementsAre("ekf", "ukf", "ekf_bank", "joint_ekf", "mhe", "high_gain", "ekf_true",
                                            "static_ridge", "constant", "ridge"));
  EXPECT_THAT(offered_by_zsh("nlo export --target a"), testing::ElementsAre("arduino"));
  EXPECT_THAT(offered_by_zsh("nlo train qube --data "), testing::AllOf(testing::Each("logs"), Contains("logs")));
}

TEST(ZshCompletion, OffersExperimentsAndFiles) {
  if (shell("command -v zsh").empty()) GTEST_SKIP() << "zsh is not installed";
  EXPECT_THAT(offered_by_zsh("nlo train "),
              testing::AllOf(IsSupersetOf({"mine.toml", "van_der_pol", "qube"}), Not(Contains("model.json"))));
  EXPECT_THAT(offered_by_zsh("nlo evaluate "), testing::AllOf(Contains("model.json"), Not(Contains("mine.toml"))));
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

TEST(Help, SaysRangesAndChoicesInWords) {
  const Scratch scratch;
  const std::string help = scratch.run({"evaluate", "--help"}).out;
  EXPECT_THAT(help, HasSubstr("--trajectories INT=200 "));
  EXPECT_THAT(help, HasSubstr("1 to 100000"));
  EXPECT_THAT(help, Not(HasSubstr("INT:INT")));
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
  scratch.write("reproduce.1", scratch.run({"reproduce", "--man"}).out);
  scratch.write("broken.1", page + ".nosuchrequest\n\\fQ text\n");
  const auto complaints = [&](const char* file) {
    return shell("groff -man -Tutf8 -ww -z '" + scratch.path() + "/" + file + "' 2>&1");
  };
  EXPECT_EQ(complaints("nlo.1"), "");
  EXPECT_EQ(complaints("reproduce.1"), "");
  EXPECT_NE(complaints("broken.1"), "");  // control
  const std::string text = shell("groff -man -Tascii -P-c '" + scratch.path() + "/nlo.1' 2>/dev/null");
  EXPECT_THAT(text, HasSubstr("nlo export model.json --target replay -o van_der_pol_replay.h"));
  EXPECT_THAT(text, Not(HasSubstr("\\f")));
}

TEST(Program, CompletesOnlyForShellsThatItKnows) {
  const Scratch scratch;
  EXPECT_THAT(scratch.refusal(2, {"completion", "fish"}), HasSubstr("bash"));
  EXPECT_EQ(scratch.run({"completion"}).exit_code, 2);
}

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
