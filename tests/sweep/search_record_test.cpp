// SPDX-License-Identifier: MIT
#include "trainer/sweep/search_record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codegen/base/error.h"
#include "trainer/report/search_page.h"
#include "trainer/sweep/search_text.h"

namespace nlo::trainer {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

/// Three candidates; the second was given up, the third is at the last rung beside the first.
SearchRecord record(std::optional<double> by_hand, std::optional<double> other) {
  SearchRecord result;
  result.identity = 0xfedcba9876543210ULL;
  result.seconds = 100.0;
  result.by_hand_s = 10.0;
  result.candidates = {{"name = \"a\"\n", "", "", {100, 400, {}}, 0.5, 50.0},
                       {"name = \"b\"\n", "observer.units = 8", "units=8", {60, 200, {}}, 0.5, 70.0},
                       {"name = \"c\"\n", "observer.units = 16", "units=16", {80, 300, {}}, 0.5, 60.0}};
  result.rungs = {{{0, 10, true, 0.5}, {1, 12, true, std::nullopt}, {2, 11, true, 0.4}},
                  {{0, 500, true, by_hand}, {2, 300, true, other}}};
  return result;
}

TEST(SearchRecord, ComesBackFromItsFile) {
  const SearchRecord written = record(0.3, std::nullopt);
  const SearchRecord found = search_record_from_json(to_json(written), "auto.json");
  EXPECT_EQ(to_json(found), to_json(written));
  EXPECT_EQ(found.identity, written.identity) << "all 64 bits";
  EXPECT_EQ(found.candidates[2].title, "units=16");
  EXPECT_FALSE(found.rungs[0][1].error);
  EXPECT_DOUBLE_EQ(*found.rungs[0][2].error, 0.4);
}

TEST(SearchRecord, RefusesWhatItCannotBe) {
  const std::string good = to_json(record(0.3, 0.2));
  const auto error_of = [](const std::string& text) -> std::string {
    try {
      (void)search_record_from_json(text, "runs/auto.json");
    } catch (const codegen::Error& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(error_of(good), "no error");
  const auto with = [&](const std::string& old, const std::string& other) {
    std::string text = good;
    const auto place = text.find(old);
    EXPECT_NE(place, std::string::npos) << old;
    return text.replace(place, old.size(), other);
  };
  for (const std::string& bad :
       {good.substr(0, good.size() / 2), std::string(), std::string("[]"), with("\"candidate\": 2", "\"candidate\": 3"),
        with("\"candidate\": 2", "\"candidate\": -1"), with("\"steps\": 10,", "\"steps\": 0,"),
        with("\"steps\": 10,", "\"steps\": 1e18,"), with("\"error\": 0.5", "\"error\": \"0.5\""),
        with("\"seconds\": 100.0", "\"seconds\": -1"), with("\"done\": true", "\"done\": 1")})
    EXPECT_THAT(error_of(bad), AllOf(StartsWith("runs/auto.json: is not a record"), HasSubstr("remove it"))) << bad;
}

// Within 2 % a seed may change the order, and what a person wrote stays.
TEST(SearchRecord, ChoosesTheLeastErrorOfTheLastRung) {
  EXPECT_EQ(record(0.300, 0.200).chosen().candidate, 2U);
  EXPECT_EQ(record(0.300, 0.295).chosen().candidate, 0U);
  EXPECT_EQ(record(0.300, 0.293).chosen().candidate, 2U);
  EXPECT_EQ(record(0.300, 0.400).chosen().candidate, 0U);
  EXPECT_EQ(record(std::nullopt, 0.400).chosen().candidate, 2U) << "the other diverged";
  EXPECT_THROW((void)record(std::nullopt, std::nullopt).chosen(), codegen::Error);
  SearchRecord without = record(0.300, 0.299);
  without.by_hand_s = 0.0;
  EXPECT_EQ(without.chosen().candidate, 2U) << "candidate 0 is no more than a draw here";
}

TEST(SearchText, TellsWhatWasFoundAndWhatItIsBeside) {
  SearchStory story{"nlo train x --auto", "x", "", record(0.3, 0.2)};
  const std::string text = search_text(story);
  EXPECT_THAT(text,
              AllOf(HasSubstr("Found, out of 3 candidates: units=16. Its error is 0.200. Beside it x as it stands has "
                              "0.300."),
                    HasSubstr("diverged"), Not(HasSubstr("more than half of the time"))));
  EXPECT_LT(text.find("units=16"), text.find("units=8")) << "who came farther is higher";
  story.record.by_hand_s = 80.0;
  EXPECT_THAT(search_text(story), HasSubstr("takes 80 s to train, more than half of the time"));
  story.record.by_hand_s = 0.0;
  EXPECT_THAT(search_text(story), HasSubstr("costs more than was allowed"));
  story.held_out = "a.csv, b.csv";
  EXPECT_THAT(search_text(story),
              HasSubstr("took these from training to choose by, and what it found is trained on all: "
                        "a.csv, b.csv"));
  story.record = record(0.3, 0.4);
  EXPECT_THAT(search_text(story), HasSubstr("x stays as it is: none of 3 candidates was better by more than 2 %"));
}

TEST(SearchPage, ShowsEveryCandidate) {
  const std::string page = search_page({"nlo train <x> --auto", "x", "", record(0.3, 0.2)}, "no-gnuplot-here");
  EXPECT_THAT(page, AllOf(HasSubstr("units=8"), HasSubstr("units=16"), HasSubstr("as it stands"),
                          HasSubstr("nlo train &lt;x&gt; --auto")));
}

}  // namespace
}  // namespace nlo::trainer
