// SPDX-License-Identifier: MIT
#include "trainer/app/sweep/results.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codegen/base/error.h"
#include "tests/support/thrown_message.h"
#include "trainer/app/report/pages.h"
#include "trainer/app/report/pareto_figure.h"
#include "trainer/app/sweep/search_record.h"
#include "trainer/app/sweep/search_text.h"

namespace nlo::trainer {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

JobResult done(double error, Eigen::Index multiply_adds, Eigen::Index flash) {
  return {
      .status = JobStatus::kDone, .validation_error = 1.0, .error = error, .cost = JobCost{multiply_adds, flash, {}}};
}

std::vector<SweepJob> planned(const std::string& text) {
  return jobs_of(parse_sweep_plan("experiment = \"tiny.toml\"\n" + text, "plan.toml"));
}

TEST(SweepResults, AreMeansOverSeedsWithStandardErrors) {
  const auto points =
      point_results(planned("seeds = [1, 2, 3]\n"), {done(1, 10, 90), done(2, 10, 95), done(6, 12, 90)});
  ASSERT_EQ(points.size(), 1U);
  EXPECT_DOUBLE_EQ(*points[0].error, 3.0);
  EXPECT_DOUBLE_EQ(*points[0].standard_error, std::sqrt((4.0 + 1.0 + 9.0) / 2.0 / 3.0));
  EXPECT_EQ(points[0].cost->multiply_adds, 12) << "the largest";
  EXPECT_EQ(points[0].cost->flash_bytes, 95);
  EXPECT_FALSE(point_results(planned(""), {done(1, 1, 1)})[0].standard_error) << "one seed has no standard error";
}

TEST(SweepResults, HaveNoMeanUntilAllSeedsAreFinished) {
  for (const JobStatus status : {JobStatus::kFailed, JobStatus::kUnfinished, JobStatus::kMissing, JobStatus::kOther}) {
    const auto points = point_results(planned("seeds = [1, 2]\n"), {done(1, 10, 10), {.status = status}});
    EXPECT_FALSE(points[0].error);
    EXPECT_EQ(points[0].done, 1U);
    EXPECT_FALSE(points[0].best_for_flash);
    EXPECT_THAT(pareto_figure(points).panels, IsEmpty());
  }
}

TEST(SweepResults, AreOnTheFrontUnlessAnotherIsAsAccurateAtALowerCost) {
  const auto points = point_results(
      planned("[grid]\na = [1, 2, 3, 4, 5]\n"),
      {done(1.0, 100, 100), done(2.0, 50, 400), done(2.0, 60, 50), done(3.0, 70, 60), done(1.0, 100, 200)});
  std::vector<bool> multiply_adds, flash;
  for (const PointResult& point : points) {
    multiply_adds.push_back(point.best_for_multiply_adds);
    flash.push_back(point.best_for_flash);
  }
  EXPECT_EQ(multiply_adds, (std::vector{true, true, false, false, true})) << "equal points are both on the front";
  EXPECT_EQ(flash, (std::vector{true, false, true, false, false}));
}

TEST(SweepResults, HaveARowForEachJob) {
  const auto all = planned("[grid]\ninverse_map.hidden = [[8], [16, 16]]\n[[point]]\nplant.model = \"a,\\\"b\\\"\"\n");
  const std::string csv =
      sweep_csv(all, {done(0.25, 10, 20), {.status = JobStatus::kFailed, .message = "diverged"}, {}});
  EXPECT_EQ(csv,
            "job,inverse_map.hidden,plant.model,seed,status,validation_error,error,multiply_adds,flash_bytes,ns\n" +
                all[0].name + ",[8],,,done,1,0.25,10,20,\n" + all[1].name + ",\"[16, 16]\",,,failed,,,,,\n" +
                all[2].name + ",,\"\"\"a,\\\"\"b\\\"\"\"\"\",,missing,,,,,\n");
}

TEST(SweepResults, NameFailedAndMissingJobs) {
  const auto all = planned("[grid]\na = [1, 2, 3]\n");
  const std::vector<JobResult> results = {
      done(0.25, 10, 20), {.status = JobStatus::kFailed, .message = "diverged"}, {}};
  const std::string text = sweep_text(all, results, point_results(all, results));
  EXPECT_THAT(text, HasSubstr("3 jobs: 1 done, 1 failed, 1 missing"));
  EXPECT_THAT(text, HasSubstr(all[1].name + ": diverged"));
}

TEST(SweepResults, HaveAThirdFrontIfTimeWasMeasured) {
  const auto all = planned("[grid]\na = [1, 2]\n");
  std::vector<JobResult> results = {done(1.0, 10, 100), done(2.0, 5, 50)};
  EXPECT_EQ(pareto_figure(point_results(all, results)).panels.size(), 2U);
  results[0].cost->ns = 40.0;
  results[1].cost->ns = 41.5;
  const auto points = point_results(all, results);
  EXPECT_TRUE(points[0].best_for_ns);
  EXPECT_FALSE(points[1].best_for_ns) << "less accurate and slower";
  EXPECT_EQ(pareto_figure(points).panels.size(), 3U);
  EXPECT_THAT(sweep_csv(all, results), HasSubstr(",5,50,41.5\n"));
}

TEST(ParetoFigure, StepsDownAtEachPointOfTheFront) {
  const auto points =
      point_results(planned("[grid]\na = [1, 2, 3]\n"), {done(1.0, 100, 100), done(2.0, 50, 400), done(3.0, 70, 500)});
  const Figure figure = pareto_figure(points);
  ASSERT_EQ(figure.panels.size(), 2U);
  const Series& front = figure.panels[0].series[0];
  EXPECT_EQ(front.x, (Eigen::VectorXd(3) << 50, 100, 100).finished());
  EXPECT_EQ(front.y, (Eigen::VectorXd(3) << 2, 2, 1).finished());
  EXPECT_EQ(figure.panels[0].series[1].x.size(), 1) << "dominated";
  EXPECT_EQ(figure.panels[0].series[3].labels, std::vector<std::string>{points[1].title})
      << "label to the right of a cheap point";
  EXPECT_EQ(figure.panels[0].series[4].labels, std::vector<std::string>{points[0].title});
  const Drawing drawing = draw({figure});
  if (!drawing.failure.empty()) GTEST_SKIP() << drawing.failure;
  EXPECT_THAT(drawing.svgs.front(), HasSubstr("aria-label=\"error norm over multiply-adds"));
  EXPECT_THAT(drawing.svgs.front(), HasSubstr(">" + points[0].title + "<"));
}

/// Three candidates: the second was given up; the third reached the last rung together with the first.
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

TEST(SearchRecord, ReadsBackFromItsFile) {
  const SearchRecord written = record(0.3, std::nullopt);
  const SearchRecord found = search_record_from_json(to_json(written), "auto.json");
  EXPECT_EQ(to_json(found), to_json(written));
  EXPECT_EQ(found.identity, written.identity) << "all 64 bits";
  EXPECT_EQ(found.candidates[2].title, "units=16");
  EXPECT_FALSE(found.rungs[0][1].error);
  EXPECT_DOUBLE_EQ(*found.rungs[0][2].error, 0.4);
}

TEST(SearchRecord, RefusesImpossibleSettings) {
  const std::string good = to_json(record(0.3, 0.2));
  const auto error_of = [](const std::string& text) -> std::string {
    return thrown_message([&] { (void)search_record_from_json(text, "runs/auto.json"); });
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

// Differences within 2 % may be due to the seed, so the experiment of the user is kept.
TEST(SearchRecord, ChoosesTheSmallestErrorOfTheLastRung) {
  EXPECT_EQ(record(0.300, 0.200).chosen().candidate, 2U);
  EXPECT_EQ(record(0.300, 0.295).chosen().candidate, 0U);
  EXPECT_EQ(record(0.300, 0.293).chosen().candidate, 2U);
  EXPECT_EQ(record(0.300, 0.400).chosen().candidate, 0U);
  EXPECT_EQ(record(std::nullopt, 0.400).chosen().candidate, 2U) << "the other candidate diverged";
  EXPECT_THROW((void)record(std::nullopt, std::nullopt).chosen(), codegen::Error);
  SearchRecord without = record(0.300, 0.299);
  without.by_hand_s = 0.0;
  EXPECT_EQ(without.chosen().candidate, 2U) << "candidate 0 is not preferred here";
}

TEST(SearchText, NamesTheWinnerAndItsAlternatives) {
  SearchStory story{"nlo train x --auto", "x", "", record(0.3, 0.2)};
  const std::string text = search_text(story);
  EXPECT_THAT(text,
              AllOf(HasSubstr("Found, out of 3 candidates: units=16. Its error is 0.200. The unchanged x has 0.300."),
                    HasSubstr("diverged"), Not(HasSubstr("more than half of the time"))));
  EXPECT_LT(text.find("units=16"), text.find("units=8")) << "candidates that reached a later rung are listed first";
  story.record.by_hand_s = 80.0;
  EXPECT_THAT(search_text(story), HasSubstr("takes 80 s to train, more than half of the time"));
  story.record.by_hand_s = 0.0;
  EXPECT_THAT(search_text(story), HasSubstr("exceeds the budget"));
  story.held_out = "a.csv, b.csv";
  EXPECT_THAT(search_text(story),
              HasSubstr("the search chose by the training logs a.csv, b.csv, which its trainings left out"));
  story.record = record(0.3, 0.4);
  EXPECT_THAT(search_text(story), HasSubstr("x stays as it is: none of 3 candidates was better by more than 2 %"));
}

TEST(SearchPage, ShowsEveryCandidate) {
  const std::string page = search_page({"nlo train <x> --auto", "x", "", record(0.3, 0.2)}, "no-gnuplot-here");
  EXPECT_THAT(page, AllOf(HasSubstr("units=8"), HasSubstr("units=16"), HasSubstr("unchanged"),
                          HasSubstr("nlo train &lt;x&gt; --auto")));
}

}  // namespace
}  // namespace nlo::trainer
