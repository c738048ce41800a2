// SPDX-License-Identifier: MIT
// A ledger is only useful if its checks can fail: each test changes a figure or a page and expects an error.
#include "tests/claims/ledger.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codegen/base/file.h"

namespace nlo::claims {
namespace {

using testing::HasSubstr;

const std::string kText = R"toml(
[[experiment]]
id = "rig"
train = "qube"
data = "qube"
seeds = 2
quick = true
set = ["training.steps=7"]
flight_noise = "gaussian:0.1"
flight_inputs = ["cos(t)"]

[[claim]]
id = "rig.rate"
experiment = "rig"
run = "evaluate --data {data}/x.csv"
metric = "/0/norm"
tolerance = 0.05
slow = true
value = 0.1
spread = 0.002

[[claim]]
id = "rig.domain"
experiment = "rig"
run = "flight"
metric = "in_domain"
at_least = 0.99

[[table]]
id = "rig"
file = "page.md"
heading = ["", "error"]
rows = [["rate", "{rig.rate} rad/s"]]
)toml";

std::string refusal(const std::string& text) {
  try {
    (void)read_ledger(text, "ledger.toml");
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

std::string with(std::string text, const std::string& old, const std::string& by) {
  text.replace(text.find(old), old.size(), by);
  return text;
}

TEST(Ledger, ReadsBackTheTextThatItWrote) {
  const std::string written = write_ledger(read_ledger(kText, "ledger.toml"));
  EXPECT_EQ(write_ledger(read_ledger(written, "again")), written);
  for (const char* part : {"value = 0.1", "at_least = 0.99", "slow = true", "set = [\"training.steps=7\"]",
                           "flight_inputs = [\"cos(t)\"]", "{rig.rate} rad/s"})
    EXPECT_THAT(written, HasSubstr(part));
}

TEST(Ledger, ReportsAFigureBeyondItsTolerance) {
  const Ledger ledger = read_ledger(kText, "ledger.toml");
  const Claim &rate = ledger.claims[0], &domain = ledger.claims[1];
  EXPECT_EQ(disagreement(rate, 0.104, false), "");
  EXPECT_THAT(disagreement(rate, 0.106, false), HasSubstr("moved from 0.1 to 0.106, by 6.0 % where 5.0 % is allowed"));
  EXPECT_THAT(disagreement(rate, 0.094, false), HasSubstr("moved"))
      << "a better figure also differs from the published one";
  EXPECT_EQ(disagreement(rate, 0.106, true), "") << "a quick run with one seed has twice the tolerance";
  EXPECT_THAT(disagreement(rate, 0.12, true), HasSubstr("moved"));
  EXPECT_THAT(disagreement(rate, std::nan(""), true), HasSubstr("not finite"));
  EXPECT_EQ(disagreement(domain, 0.995, true), "");
  EXPECT_THAT(disagreement(domain, 0.98, true), HasSubstr("below 0.99"));
}

TEST(Ledger, RefusesEntriesThatNameNothingOrCannotFail) {
  EXPECT_EQ(refusal(kText), "");
  EXPECT_THAT(refusal(with(kText, "experiment = \"rig\"", "experiment = \"rag\"")), HasSubstr("no experiment \"rag\""));
  EXPECT_EQ(
      refusal(with(kText, "experiment = \"rig\"\nrun = \"flight\"", "run = \"identify qube --data {data}/qube\"")), "")
      << "an identification has no training";
  EXPECT_THAT(refusal(with(kText, "experiment = \"rig\"\nrun = \"flight\"", "run = \"identified\"")),
              HasSubstr("no experiment"));
  EXPECT_THAT(refusal(with(kText, "{rig.rate}", "{rig.rat}")), HasSubstr("no claim \"rig.rat\""));
  EXPECT_THAT(refusal(with(kText, "id = \"rig.domain\"", "id = \"rig.rate\"")), HasSubstr("twice"));
  EXPECT_THAT(refusal(with(kText, "at_least = 0.99\n", "")), HasSubstr("can't fail"));
  EXPECT_THAT(refusal(with(kText, "[[\"rate\", ", "[[")), HasSubstr("a row has 1 cells"));
}

TEST(Ledger, ASpreadThatRoundsToZeroIsNotShown) {
  Claim claim;
  claim.measured = true;
  claim.value = 0.0952;
  claim.spread = 1e-9;
  EXPECT_EQ(figure_text(claim), "0.0952");
  claim.spread = 0.0004;
  EXPECT_EQ(figure_text(claim), "0.0952 ± 0.00040");
  claim.value = 1.99;
  EXPECT_EQ(figure_text(claim), "1.99");
  claim.value = 0.0;
  EXPECT_EQ(figure_text(claim), "0");
  claim.measured = false;
  EXPECT_EQ(figure_text(claim), "not measured");
}

TEST(Ledger, TablesReplaceTheTextBetweenTheirMarkers) {
  const Ledger ledger = read_ledger(kText, "ledger.toml");
  const std::string page = "# Page\n<!-- results rig -->\nold\n<!-- end of results -->\nrest\n";
  const std::string now = with_tables(ledger, "page.md", page);
  EXPECT_THAT(now, HasSubstr("|  | error |\n|---|---|\n| rate | 0.100 ± 0.0020 rad/s |\n"));
  EXPECT_THAT(now, testing::Not(HasSubstr("old")));
  EXPECT_EQ(with_tables(ledger, "page.md", now), now);
  EXPECT_THROW((void)with_tables(ledger, "page.md", "no markers"), std::runtime_error);
  EXPECT_THROW((void)with_tables(ledger, "page.md", page + "<!-- results other -->"), std::runtime_error);
}

TEST(Ledger, TheShippedPagesShowTheFiguresOfTheLedger) {
  const std::string root = std::string(NLO_SOURCE_DIR) + "/", file = "docs/results.toml";
  const std::string text = codegen::read_file(root + file);
  const Ledger ledger = read_ledger(text, file);
  EXPECT_TRUE(write_ledger(ledger) == text) << file << "  is not formatted: run claims --tables";
  for (const Claim& claim : ledger.claims) EXPECT_TRUE(claim.measured) << claim.id << ": run claims --update";
  for (const Table& table : ledger.tables) {
    const std::string page = codegen::read_file(root + table.file);
    EXPECT_TRUE(with_tables(ledger, table.file, page) == page) << table.file << ": run claims --tables";
  }
}

}  // namespace
}  // namespace nlo::claims
