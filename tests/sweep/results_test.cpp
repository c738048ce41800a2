// SPDX-License-Identifier: MIT
#include "trainer/sweep/results.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "trainer/report/pareto_figure.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

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
  EXPECT_FALSE(point_results(planned(""), {done(1, 1, 1)})[0].standard_error) << "one seed has no scatter";
}

TEST(SweepResults, HaveNoMeanOfSomeOfTheSeeds) {
  for (const JobStatus status : {JobStatus::kFailed, JobStatus::kUnfinished, JobStatus::kMissing, JobStatus::kOther}) {
    const auto points = point_results(planned("seeds = [1, 2]\n"), {done(1, 10, 10), {.status = status}});
    EXPECT_FALSE(points[0].error);
    EXPECT_EQ(points[0].done, 1U);
    EXPECT_FALSE(points[0].best_for_flash);
    EXPECT_THAT(pareto_figure(points).panels, IsEmpty());
  }
}

TEST(SweepResults, AreOnTheFrontUnlessAnotherIsAsGoodForLess) {
  const auto points = point_results(
      planned("[grid]\na = [1, 2, 3, 4, 5]\n"),
      {done(1.0, 100, 100), done(2.0, 50, 400), done(2.0, 60, 50), done(3.0, 70, 60), done(1.0, 100, 200)});
  std::vector<bool> multiply_adds, flash;
  for (const PointResult& point : points) {
    multiply_adds.push_back(point.best_for_multiply_adds);
    flash.push_back(point.best_for_flash);
  }
  EXPECT_EQ(multiply_adds, (std::vector{true, true, false, false, true})) << "equals are both there";
  EXPECT_EQ(flash, (std::vector{true, false, true, false, false}));
}

TEST(SweepResults, AreARowForEachJob) {
  const auto all = planned("[grid]\ninverse_map.hidden = [[8], [16, 16]]\n[[point]]\nplant.model = \"a,\\\"b\\\"\"\n");
  const std::string csv =
      sweep_csv(all, {done(0.25, 10, 20), {.status = JobStatus::kFailed, .message = "diverged"}, {}});
  EXPECT_EQ(csv,
            "job,inverse_map.hidden,plant.model,seed,status,validation_error,error,multiply_adds,flash_bytes,ns\n" +
                all[0].name + ",[8],,,done,1,0.25,10,20,\n" + all[1].name + ",\"[16, 16]\",,,failed,,,,,\n" +
                all[2].name + ",,\"\"\"a,\\\"\"b\\\"\"\"\"\",,missing,,,,,\n");
}

TEST(SweepResults, SayWhatFailedAndWhatIsMissing) {
  const auto all = planned("[grid]\na = [1, 2, 3]\n");
  const std::vector<JobResult> results = {
      done(0.25, 10, 20), {.status = JobStatus::kFailed, .message = "diverged"}, {}};
  const std::string text = sweep_text(all, results, point_results(all, results));
  EXPECT_THAT(text, HasSubstr("3 jobs: 1 done, 1 failed, 1 missing"));
  EXPECT_THAT(text, HasSubstr(all[1].name + ": diverged"));
}

TEST(SweepResults, HaveAThirdFrontWhereTimeWasMeasured) {
  const auto all = planned("[grid]\na = [1, 2]\n");
  std::vector<JobResult> results = {done(1.0, 10, 100), done(2.0, 5, 50)};
  EXPECT_EQ(pareto_figure(point_results(all, results)).panels.size(), 2U);
  results[0].cost->ns = 40.0;
  results[1].cost->ns = 41.5;
  const auto points = point_results(all, results);
  EXPECT_TRUE(points[0].best_for_ns);
  EXPECT_FALSE(points[1].best_for_ns) << "worse, and slower by cache or width";
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
  EXPECT_EQ(figure.panels[0].series[3].labels, std::vector<std::string>{points[1].title}) << "cheap: to the right";
  EXPECT_EQ(figure.panels[0].series[4].labels, std::vector<std::string>{points[0].title});
  const Drawing drawing = draw({figure});
  if (!drawing.failure.empty()) GTEST_SKIP() << drawing.failure;
  EXPECT_THAT(drawing.svgs.front(), HasSubstr("aria-label=\"error norm over multiply-adds"));
  EXPECT_THAT(drawing.svgs.front(), HasSubstr(">" + points[0].title + "<"));
}

}  // namespace
}  // namespace nlo::trainer
