// SPDX-License-Identifier: MIT
// Text from anywhere: an error or an experiment, never a crash, never a hang.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "tests/experiments/experiment_text.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;

std::string repeated(const std::string& text, int times) {
  std::string result;
  for (int i = 0; i < times; ++i) result += text;
  return result;
}

TEST(HostileToml, DeepNestingIsAnError) {
  EXPECT_THAT(error_of("x = " + std::string(100000, '[')),
              HasSubstr("e.toml:1: brackets are nested more than 32 deep"));
  EXPECT_THAT(error_of("x = " + repeated("{a=", 100000)), HasSubstr("nested more than"));
  EXPECT_THAT(error_of("\n\nx" + repeated(".a", 100000) + " = 1"), HasSubstr("e.toml:3: a key has more than 16 dots"));
  EXPECT_THAT(error_of("[x" + repeated(" . \"a\"", 100000) + "]"), HasSubstr("dots"));
}

TEST(HostileToml, BracketsInStringsAndCommentsDoNotCount) {
  const std::string brackets(200, '[');
  EXPECT_EQ(error_of("# " + brackets + "\n" + kPlantExperiment + "# " + brackets), "no error");
  EXPECT_THAT(error_of("x = \"\\\"" + brackets + "\""), HasSubstr("unknown key \"x\""));
  EXPECT_THAT(error_of("x = '''\n\"" + brackets + "'''"), HasSubstr("unknown key \"x\""));
  EXPECT_THAT(error_of("x = \"\"\"\\\"\"\"" + brackets + "\"\"\"\""), HasSubstr("unknown key \"x\""));
  EXPECT_THAT(error_of("x = '" + brackets + "\ny = " + brackets), HasSubstr("nested more than"));
}

TEST(HostileToml, TooBigNotTextOrBroken) {
  EXPECT_THAT(error_of(std::string(2'000'000, '#')), HasSubstr("too big"));
  EXPECT_THAT(error_of("name = \"x\"\ny = \"\xff\""), HasSubstr("e.toml:2: byte 0xFF is not text"));
  EXPECT_THAT(error_of(std::string("a\0b", 3)), HasSubstr("byte 0x00"));
  EXPECT_THAT(error_of("a = \"\xed\xa0\x80\""), HasSubstr("byte 0xED"));  // a surrogate
  EXPECT_THAT(error_of(""), HasSubstr("no name"));
  EXPECT_THAT(error_of("a = 1\na = 2"), HasSubstr("e.toml:2: "));
  EXPECT_THAT(error_of("a = [1,\n2\n"), HasSubstr("e.toml:"));
  EXPECT_THAT(error_of("a = 'x"), HasSubstr("e.toml:1: "));
}

TEST(HostileToml, ManyKeysAreRefusedBeforeTheyCostTime) {
  std::string text;
  for (int i = 0; i < 60000; ++i) text.append("a").append(std::to_string(i)).append(" = 1\n");
  EXPECT_THAT(error_of(text), HasSubstr("has 60000 keys"));
}

TEST(HostileToml, SurvivesRandomEdits) {
  std::mt19937 engine(12345);
  const std::string alphabet = "[]{}\"'=.,#\n\\ ax1-_\t\r\xc3";
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(engine()) % n; };
  int accepted = 0;
  for (int round = 0; round < 3000; ++round) {
    std::string text = round % 2 == 0 ? kPlantExperiment : kLogExperiment;
    for (std::size_t edits = 1 + below(4); edits > 0; --edits) {
      const std::size_t at = below(text.size());
      switch (below(3)) {
        case 0:
          text[at] = alphabet[below(alphabet.size())];
          break;
        case 1:
          text.insert(at, 1, alphabet[below(alphabet.size())]);
          break;
        default:
          text.erase(at, 1 + below(5));
      }
    }
    accepted += error_of(text) == "no error";
  }
  EXPECT_GT(accepted, 0);  // control: else every edit met the same early error
}

}  // namespace
}  // namespace nlo::trainer
