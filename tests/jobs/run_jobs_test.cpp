// SPDX-License-Identifier: MIT
// Lists of jobs: which jobs are run, found finished, stopped and failed. The progress bar of many trainings. Trainings
// that are kept in a folder whose files may be damaged.
#include "trainer/app/jobs/run_jobs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "tests/support/scratch_directory.h"
#include "trainer/app/jobs/jobs_progress.h"
#include "trainer/app/jobs/kept_training.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

Job job(const std::string& name, std::function<JobEnd(const JobContext&)> work) {
  return {name, 1.0, std::move(work)};
}

TEST(RunJobs, RunsJobsInOrderWithAllThreadsIfOneAtATime) {
  std::vector<std::string> ran;
  const auto note = [&](const JobContext& context) {
    ran.push_back(context.name + " " + std::to_string(context.threads));
    return context.name == "b" ? JobEnd::kFound : JobEnd::kDone;
  };
  const JobsResult result =
      run_jobs({job("a", note), job("b", note), job("c", note)}, {.threads = 3, .side_by_side = false});
  EXPECT_THAT(ran, ElementsAre("a 3", "b 3", "c 3"));
  EXPECT_EQ(result.done, 2U);
  EXPECT_EQ(result.found, 1U);
  EXPECT_EQ(result.left, 0U);
}

/// Each job waits for the other. If they ran one by one, the first would wait until its limit of a minute.
TEST(RunJobs, SharesTheThreadsIfJobsRunInParallel) {
  std::atomic<int> inside{0}, threads{0};
  const auto meet = [&](const JobContext& context) {
    threads += context.threads;
    ++inside;
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (inside < 2 && std::chrono::steady_clock::now() < give_up) std::this_thread::yield();
    return inside >= 2 ? JobEnd::kDone : JobEnd::kStopped;
  };
  EXPECT_EQ(run_jobs({job("a", meet), job("b", meet)}, {.threads = 4}).done, 2U);
  EXPECT_EQ(threads, 4);
  EXPECT_EQ(run_jobs({}, {.threads = 4}).left, 0U);
}

TEST(RunJobs, AStopKeepsTheFinishedJobsAndSaysHowToContinue) {
  std::atomic<bool> stop{false};
  const auto stops = [&](const JobContext& context) {
    stop.store(true);
    EXPECT_TRUE(context.stop->load());
    return JobEnd::kStopped;
  };
  const auto done = [](const JobContext&) { return JobEnd::kDone; };
  const JobsResult result = run_jobs({job("a", done), job("b", stops), job("c", done)}, {.threads = 1, .stop = &stop});
  EXPECT_EQ(result.done, 1U);
  EXPECT_EQ(result.left, 2U);
  EXPECT_EQ(result.interrupted_text("nlo more"), "interrupted with 2 of 3 trainings left; to continue: nlo more");
  // A job that throws because it was stopped has not failed.
  stop.store(false);
  const auto throws = [&](const JobContext&) -> JobEnd {
    stop.store(true);
    throw std::runtime_error("interrupted");
  };
  const JobsResult thrown = run_jobs({job("a", throws)}, {.threads = 1, .stop = &stop});
  EXPECT_EQ(thrown.left, 1U);
  EXPECT_TRUE(thrown.failures.empty());
}

TEST(RunJobs, AFailureStopsTheOtherJobsUnlessTheyAreToldToContinue) {
  const auto fails = [](const JobContext& context) -> JobEnd { throw std::runtime_error(context.name); };
  const auto done = [](const JobContext&) { return JobEnd::kDone; };
  const std::vector<Job> jobs = {job("a", fails), job("b", done), job("c", fails)};
  const JobsResult first = run_jobs(jobs, {.threads = 1});
  EXPECT_EQ(first.failures.size(), 1U);
  EXPECT_EQ(first.left, 2U);
  const JobsResult all = run_jobs(jobs, {.threads = 1, .keep_going = true});
  EXPECT_EQ(all.done, 1U);
  EXPECT_EQ(all.failures.size(), 2U);
  try {
    all.check();
    ADD_FAILURE() << "no failure was thrown";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "a");
  }
  EXPECT_NO_THROW(run_jobs({job("b", done)}, {}).check());
}

TEST(RunJobs, DisplayCountsJobsThatAreTrainedAndOmitsFinishedOnes) {
  std::FILE* file = std::tmpfile();
  {
    StatusLine line(file, StatusLine::Mode::kLog, true);
    JobsProgress progress(line);
    const auto found = [](const JobContext&) { return JobEnd::kFound; };
    const auto trains = [](const JobContext& context) {
      for (const double share : {0.5, 1.0, 0.5, 1.0}) context.progress(share);  // trains twice
      return JobEnd::kDone;
    };
    run_jobs({job("a", found), job("b", trains), job("c", trains)},
             {.threads = 1, .side_by_side = false, .progress = &progress});
    progress.finish();
  }
  std::rewind(file);
  std::string text(10000, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file));
  std::fclose(file);
  EXPECT_THAT(text, testing::StartsWith("25 %, 0/2 models"));
  EXPECT_THAT(text, testing::HasSubstr("\n75 %, 1/2 models"));
  EXPECT_THAT(text, testing::EndsWith("\n100 %, 2/2 models, took 0 s\n"));
}

const JobsState kHalf{0.5, 3, 6, "training van_der_pol_fast, seed 2", 60.0, 60.0};

TEST(JobsBar, FitsItsColumns) {
  for (const bool utf8 : {true, false})
    for (std::size_t columns = 1; columns < 140; ++columns)
      EXPECT_LE(display_width(jobs_bar_line(kHalf, columns, utf8)), columns) << columns;
}

TEST(JobsBar, ShowsShareModelsTimeAndTask) {
  const std::string line = jobs_bar_line(kHalf, 120, true);
  for (const char* fact : {"50 %", "3/6 models", "1:00 left", "seed 2"}) EXPECT_THAT(line, HasSubstr(fact));
}

TEST(JobsLog, IsOneLineWithShareModelsAndTimes) {
  EXPECT_EQ(jobs_log_line(kHalf), "50 %, 3/6 models, 1:00 left: training van_der_pol_fast, seed 2");
  EXPECT_EQ(jobs_log_line({0.001, 0, 6, "", 1.0, 999.0}), "0 %, 0/6 models");  // too early to estimate the time left
}

/// The log of a run that advances 200 times.
std::string logged_run() {
  std::FILE* file = std::tmpfile();
  {
    StatusLine line(file, StatusLine::Mode::kLog, true);
    JobsProgress progress(line);
    progress.expect(3.0, 2);
    progress.expect(-2.0, -1);
    for (int i = 0; i < 200; ++i) progress.advance(1.0 / 200, "training");
    progress.model_done(0.0, "a, seed 1");
    progress.finish();
  }
  std::rewind(file);
  std::string text(10000, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file));
  std::fclose(file);
  return text;
}

TEST(JobsProgress, LogHasOneLineForEachTenthAndForTheEnd) {
  const std::string text = logged_run();
  EXPECT_THAT(text, StartsWith("0 %"));
  EXPECT_THAT(text, HasSubstr("\n100 %, 1/1 models, took 0 s\n"));
  const auto lines = std::count(text.begin(), text.end(), '\n');
  EXPECT_GE(lines, 10);
  EXPECT_LE(lines, 13) << text;
}

const JobContext kContext{"a", 1, nullptr, [](double) {}};

TEST(KeptTraining, ADamagedCheckpointRestartsTheTrainingInsteadOfFailingIt) {
  const ScratchDirectory scratch;
  const std::string folder = scratch.path("kept");
  std::vector<bool> resumed;
  const TrainingWork train = [&](const TrainOptions& options) {
    resumed.push_back(options.resume);
    if (options.resume) throw codegen::InputError("a damaged file");
    return TrainingResult{};
  };
  resume_or_begin(folder, kContext, train);
  EXPECT_EQ(resumed, std::vector<bool>{false}) << "there was no checkpoint to continue from";
  scratch.write("kept/checkpoint.bin", "damaged");
  resume_or_begin(folder, kContext, train);
  EXPECT_EQ(resumed, (std::vector<bool>{false, true, false}));
  // Control: a training that fails without a checkpoint also fails here.
  std::filesystem::remove_all(folder);
  const TrainingWork refuses = [](const TrainOptions&) -> TrainingResult { throw codegen::InputError("wrong input"); };
  EXPECT_THROW(resume_or_begin(folder, kContext, refuses), codegen::InputError);
  EXPECT_THROW(resume_or_begin("", kContext, refuses), codegen::InputError);
}

TEST(KeptTraining, HasAFolderForEachExperimentAndData) {
  std::set<std::string> folders;
  for (const FinishedRun& inputs : {FinishedRun{1, 0}, {2, 0}, {1, 2}, {12, 0}, {1, 20}})
    EXPECT_TRUE(folders.insert(kept_folder("root", inputs)).second) << inputs.experiment << " " << inputs.data;
}

}  // namespace
}  // namespace nlo::trainer
