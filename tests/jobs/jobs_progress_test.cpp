// SPDX-License-Identifier: MIT
// The bar over many trainings.
#include "trainer/jobs/jobs_progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <string>

#include "trainer/evaluation/text.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

const JobsState kHalf{0.5, 3, 6, "training van_der_pol_fast, seed 2", 60.0, 60.0};

TEST(JobsBar, FitsItsColumns) {
  for (const bool utf8 : {true, false})
    for (std::size_t columns = 1; columns < 140; ++columns)
      EXPECT_LE(display_width(jobs_bar_line(kHalf, columns, utf8)), columns) << columns;
}

TEST(JobsBar, TellsShareModelsTimeAndTask) {
  const std::string line = jobs_bar_line(kHalf, 120, true);
  for (const char* fact : {"50 %", "3/6 models", "1:00 left", "seed 2"}) EXPECT_THAT(line, HasSubstr(fact));
}

TEST(JobsLog, IsOneLineOfFacts) {
  EXPECT_EQ(jobs_log_line(kHalf), "50 %, 3/6 models, 1:00 left: training van_der_pol_fast, seed 2");
  EXPECT_EQ(jobs_log_line({0.001, 0, 6, "", 1.0, 999.0}), "0 %, 0/6 models");  // too early to tell the time left
}

/// What a run of 200 advances writes to a log.
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

TEST(JobsProgress, ALogGetsALineForEachTenthAndSaysHundredPercentOnce) {
  const std::string text = logged_run();
  EXPECT_THAT(text, StartsWith("0 %"));
  EXPECT_THAT(text, HasSubstr("\n100 %, 1/1 models, took 0 s\n"));
  const auto lines = std::count(text.begin(), text.end(), '\n');
  EXPECT_GE(lines, 10);
  EXPECT_LE(lines, 13) << text;
}

}  // namespace
}  // namespace nlo::trainer
