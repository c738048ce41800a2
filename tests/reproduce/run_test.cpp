// SPDX-License-Identifier: MIT
// `nlo reproduce` end to end on its smallest item: cache, interruption, page. Comparison with the paper's numbers:
// statistics, marks, CSV.
#include "trainer/reproduce/run.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "tests/support/scratch_directory.h"
#include "tests/support/thrown_message.h"
#include "trainer/app/jobs/kept_training.h"
#include "trainer/reproduce/numbers_csv.h"
#include "trainer/reproduce/planned_trainings.h"
#include "trainer/reproduce/section.h"

namespace nlo::trainer::reproduction {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kItem = "figure-reg-traj";
constexpr Size kTiny{.steps = 0.02, .test_trajectories = 2, .map_points = 3};

class Reproduction : public testing::Test {
 protected:
  Request tiny(const std::string& directory = "a") const {
    Request request;
    request.what = kItem;
    request.directory = scratch_.path(directory);
    request.size = kTiny;
    request.quick = true;
    request.seeds = 1;
    request.threads = 1;
    return request;
  }

  static Result run(const Request& request) {
    StatusLine line(stderr, StatusLine::Mode::kSilent, false);
    JobsProgress progress(line);
    return reproduce(request, progress);
  }

  static std::string model_file(const Request& request, int seed) {
    const Experiment experiment = paper_draft("van_der_pol_regularised", request.size, seed).experiment;
    return kept_folder(request.directory + "/cache", {run_identity(experiment)}) + "/model.json";
  }

  const ScratchDirectory scratch_;
};

TEST_F(Reproduction, ASecondRunTrainsNothingAndGivesTheSameBytes) {
  const Request request = tiny();
  EXPECT_EQ(run(request).trainings.done, 1U);
  const std::string page = codegen::read_file(request.directory + "/reproduction.html");
  const Result second = run(request);
  EXPECT_EQ(second.trainings.done, 0U);
  EXPECT_EQ(second.trainings.found, 1U);
  EXPECT_EQ(codegen::read_file(request.directory + "/reproduction.html"), page);
}

TEST_F(Reproduction, ADrivenObserverIsAlsoTestedWithoutItsInput) {
  Request request = tiny();
  request.what = "figure-duff-exc";
  request.size.steps = 0.005;
  const Result result = run(request);
  ASSERT_EQ(result.sections.size(), 1U);
  EXPECT_EQ(result.sections.front().second.tables.front().rows.size(), 2U);
}

TEST_F(Reproduction, APublishedBenchmarkHasATableForEachTestAndNumbersForTheLedger) {
  Request request = tiny();
  request.what = "hyperkkl";
  request.size.steps = 0.0005;
  const Result result = run(request);
  ASSERT_EQ(result.sections.size(), 1U);
  const Section& section = result.sections.front().second;
  ASSERT_EQ(section.contests.size(), 5U);
  EXPECT_EQ(section.contests[0].cells.size(), 20U);
  for (const Contender& cell : section.contests[0].cells)
    EXPECT_EQ(cell.published.has_value(), cell.model != "Lorenz") << cell.model;
  EXPECT_THAT(codegen::read_file(request.directory + "/hyperkkl.csv"),
              HasSubstr("inputs as in training,Duffing,zero,components,smape,5.6,"));
  EXPECT_THAT(codegen::read_file(request.directory + "/reproduction.html"), HasSubstr("FitzHugh-Nagumo, square"));
}

TEST_F(Reproduction, LorenzMeasurementsHaveTheStatedNoiseAndATunedFilterFollowsThePlant) {
  constexpr double kDrawsDb = 0.3;       // standard error of 9,000 squares: 1.5 %, which is .07 dB
  constexpr double kFilteredDb = -15.0;  // measured: -17.7 dB over 50 runs; a filter that diverges has more than 0
  Request request = tiny();
  request.what = "lorenz";
  request.size.steps = 0.0005;
  const ExamTable exam = run(request).sections.front().second.exams.front();
  const auto value = [&exam](const std::string& name) {
    for (const ExamRow& row : exam.rows)
      if (row.name == name) return row.values.front();
    return std::nan("");
  };
  EXPECT_NEAR(value("the measurement itself"), 0.0, kDrawsDb);
  EXPECT_LT(value("EKF, tuned"), kFilteredDb);
  EXPECT_GT(*exam.rows.front().multiply_adds, 1000.0);
  EXPECT_THAT(codegen::read_file(request.directory + "/lorenz.csv"),
              HasSubstr("\"Lorenz, decimated\",\"EKF, tuned\",MSE [dB],test,figure,,"));
}

TEST_F(Reproduction, ABenchmarkWithoutItsLogsIsRefusedAndTheErrorNamesTheOption) {
  Request request = tiny();
  request.what = "charge";
  EXPECT_THAT(thrown_message([&] { run(request); }), HasSubstr("name the folder that holds battery/ by --data"));
  EXPECT_FALSE(fs::exists(request.directory));
  request.data = scratch_.path("empty");
  EXPECT_THAT(thrown_message([&] { run(request); }), HasSubstr("there is no " + request.data + "/battery"));
}

/// Returns the text of a log of y' = 40 (u - y) with an input of two tones, at the sample rate of the Silverbox.
std::string two_tones(int samples, double phase, double first_y) {
  constexpr double kPeriodS = 0.00163840419, kRate = 40.0;
  constexpr int kStart = 50;  // samples whose truth is `first_y`
  std::string text = "t,u,y\n";
  double y = 0.0;
  for (int k = 0; k < samples; ++k) {
    const double t = kPeriodS * k, u = std::sin(90.0 * t + phase) + std::sin(37.0 * t + 2.0 * phase);
    text += fmt::format("{},{},{}\n", t, u, k < kStart ? first_y : y);
    y += kPeriodS * kRate * (u - y);
  }
  return text;
}

TEST_F(Reproduction, SilverboxIsDerivedFromItsLogsAndItsFirstFiftySamplesAreNotScored) {
  constexpr double kNever = 100.0;        // V; 50 samples with this error would add 35 V to the error of 400 samples
  constexpr double kDeviationMv = 500.0;  // standard deviation of y, whose two tones have amplitudes of 0.4 and 0.7 V
  for (int i = 0; i < 4; ++i)
    scratch_.write(fmt::format("logs/silverbox/train_{}.csv", i), two_tones(400, 1.0 + i, 0.0));
  for (const char* test : {"multisine", "arrow", "arrow_noextrap"})
    scratch_.write(fmt::format("logs/silverbox/test_{}.csv", test), two_tones(400, 0.5, kNever));
  Request request = tiny();
  request.what = "silverbox";
  request.data = scratch_.path("logs");
  const std::vector<ExamTable> exams = run(request).sections.front().second.exams;
  ASSERT_EQ(exams.size(), 3U);
  for (const ExamTable& exam : exams) {
    EXPECT_LT(exam.rows.front().values.front(), 2.0 * kDeviationMv) << exam.title;
    EXPECT_TRUE(exam.rows.back().published.has_value()) << exam.title;
  }
  EXPECT_THAT(codegen::read_file(request.directory + "/silverbox.csv"),
              HasSubstr("\"Silverbox, arrow\",\"nlo, derived\",RMSE [mV],test,figure,,"));
  EXPECT_THAT(codegen::read_file(request.directory + "/reproduction.html"), HasSubstr("Gaussian process NARX"));
}

TEST_F(Reproduction, TrainsAgainForAnotherConfigOrSeed) {
  Request request = tiny();
  run(request);
  request.size.steps *= 2.0;
  EXPECT_EQ(run(request).trainings.done, 1U);
  request.seeds = 2;
  const Result more_seeds = run(request);
  EXPECT_EQ(more_seeds.trainings.done, 1U);
  EXPECT_EQ(more_seeds.trainings.found, 1U);
}

TEST_F(Reproduction, ADamagedModelIsTrainedAgain) {
  const Request request = tiny();
  run(request);
  const std::string good = codegen::read_file(model_file(request, 1));
  codegen::write_file_atomically(model_file(request, 1), good.substr(0, good.size() / 2));
  EXPECT_EQ(run(request).trainings.done, 1U);
  EXPECT_EQ(codegen::read_file(model_file(request, 1)), good);
}

TEST_F(Reproduction, AnInterruptedRunKeepsFinishedTrainingsAndReachesTheSameBytes) {
  Request request = tiny();
  request.seeds = 2;
  std::atomic<bool> stop{false};
  request.stop = &stop;
  // Ctrl-C when the first of the two models is in the cache.
  std::thread interrupter([&] {
    while (!fs::exists(model_file(request, 1)) && !fs::exists(model_file(request, 2)))
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    stop.store(true);
  });
  const Result interrupted = run(request);
  interrupter.join();
  EXPECT_TRUE(interrupted.interrupted);
  EXPECT_FALSE(fs::exists(request.directory + "/reproduction.html"));

  stop.store(false);
  const Result resumed = run(request);
  EXPECT_FALSE(resumed.interrupted);
  EXPECT_GE(resumed.trainings.found, 1U);
  EXPECT_EQ(resumed.trainings.found + resumed.trainings.done, 2U);

  Request uninterrupted = tiny("b");
  uninterrupted.seeds = 2;
  run(uninterrupted);
  EXPECT_EQ(codegen::read_file(model_file(request, 2)), codegen::read_file(model_file(uninterrupted, 2)));
}

TEST_F(Reproduction, ThePageIsSelfContainedAndSaysThatTheRunWasQuick) {
  const Request request = tiny();
  run(request);
  const std::string page = codegen::read_file(request.directory + "/reproduction.html");
  for (const char* link : {"<script", "<link", "src=", "href=\"http", "url(", "@import"})
    EXPECT_THAT(page, Not(HasSubstr(link)));
  EXPECT_THAT(page, HasSubstr("A quick run"));
  EXPECT_THAT(page, HasSubstr("nlo reproduce figure-reg-traj"));
  EXPECT_THAT(page, HasSubstr("reg-traj"));
  EXPECT_THAT(page, HasSubstr("</html>"));
}

TEST_F(Reproduction, WritesOneCsvOfCurvesAndOneOfNumbersForAFigure) {
  const Request request = tiny();
  run(request);
  const std::string base = request.directory + "/" + kItem;
  const std::string curves = codegen::read_file(base + ".csv");
  EXPECT_EQ(curves.substr(0, curves.find('\n')),
            "time_s,regularised_x1,regularised_x2,regularised_y,regularised_x1_hat,regularised_x2_hat");
  EXPECT_EQ(std::count(curves.begin(), curves.end(), '\n'), 2502);  // a heading and 50 s at 0.02 s
  EXPECT_THAT(codegen::read_file(base + "-numbers.csv"), HasSubstr("paper-like,nrmse"));
}

TEST_F(Reproduction, AnUnknownItemWritesNothing) {
  Request request = tiny();
  request.what = "table9";
  EXPECT_THROW(run(request), codegen::Error);
  EXPECT_FALSE(fs::exists(request.directory));
}

TEST(Spread, IsMeanAndPopulationDeviation) {
  const Spread s = spread({1.0, 2.0, 3.0});
  EXPECT_DOUBLE_EQ(s.mean, 2.0);
  EXPECT_DOUBLE_EQ(s.deviation, std::sqrt(2.0 / 3.0));  // divided by n, not n - 1
  EXPECT_TRUE(std::isnan(spread({}).mean));
}

TEST(Cell, IsMarkedIfItDiffersByMoreThanThirtyFivePercentInThePaperLikeMetric) {
  const double inside = 1.34, outside = 1.36;
  EXPECT_FALSE(is_outside({1.0, {5.0}, {inside}}));
  EXPECT_TRUE(is_outside({1.0, {1.0}, {outside}}));
  EXPECT_TRUE(is_outside({1.0, {1.0}, {2.0 - outside}}));
  EXPECT_FALSE(is_outside({std::nullopt, {1.0}, {99.0}}));
}

Section two_cells() {
  Section section;
  section.tables.push_back(
      {"", "noise", {"a, quoted", "b"}, {"none"}, {{{0.5, {1.0, 3.0}, {0.25, 0.75}}, {std::nullopt, {2.0}, {}}}}});
  return section;
}

TEST(NumbersCsv, HasALinePerCellAndReading) {
  EXPECT_EQ(numbers_csv(two_cells()),
            "table,row,column,reading,metric,paper,mean,deviation,relative_to_paper,seed_1,seed_2\n"
            ",none,\"a, quoted\",strict,norm,0.5,2,1,,1,3\n"
            ",none,\"a, quoted\",paper-like,nrmse,0.5,0.5,0.25,0,0.25,0.75\n"
            ",none,b,strict,norm,,2,0,,2\n");
  EXPECT_EQ(numbers_csv({}), "");
}

TEST(ColumnsCsv, WritesEachSeriesAsAColumn) {
  const Eigen::VectorXd time = Eigen::Vector2d(0.0, 0.5), x = Eigen::Vector2d(-1.0, 0.1);
  EXPECT_EQ(columns_csv({{"time_s", time}, {"x1", x}}), "time_s,x1\n0,-1\n0.5,0.1\n");
}

}  // namespace
}  // namespace nlo::trainer::reproduction
