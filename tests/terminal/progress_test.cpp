// SPDX-License-Identifier: MIT
#include "trainer/app/terminal/progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::Not;

TrainProgress halfway() {
  return {500, 1000, 0.03142, 0.1842, {{-0.26, 0.92}, {-1.25, 0.0}, {-7.0, 0.0}}, 83.4, 6.0, 6.0};
}

/// Returns the text that `use` makes a display write to a stream that is not a terminal.
template <class Use>
std::string written(ProgressDisplay::Mode mode, Use use) {
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::tmpfile(), std::fclose);
  {
    ProgressDisplay display(file.get(), mode, true, 120);
    use(display);
  }
  std::rewind(file.get());
  std::string text;
  for (int c = std::fgetc(file.get()); c != EOF; c = std::fgetc(file.get())) text += static_cast<char>(c);
  return text;
}

long count(const std::string& text, char wanted) {
  return std::count(text.begin(), text.end(), wanted);
}

TEST(Progress, WideLineShowsEverything) {
  EXPECT_EQ(progress_bar_line(halfway(), 140, true),
            "███████████████░░░░░░░░░░░░░░░  500/1000  loss 0.0314  rmse 0.184  λ -0.26±0.92i, -1.2, -7.0  83.4 "
            "steps/s  6 s left");
}

TEST(Progress, LineNeverExceedsTheTerminal) {
  for (const bool utf8 : {true, false})
    for (std::size_t columns = 0; columns < 160; ++columns)
      EXPECT_LE(display_width(progress_bar_line(halfway(), columns, utf8)), columns);
}

TEST(Progress, NarrowLineDropsEigenvaluesFirst) {
  EXPECT_THAT(progress_bar_line(halfway(), 80, true), Not(HasSubstr("λ")));
  EXPECT_THAT(progress_bar_line(halfway(), 80, true), HasSubstr("steps/s"));
  EXPECT_THAT(progress_bar_line(halfway(), 60, true), HasSubstr("6 s left"));
  EXPECT_THAT(progress_bar_line(halfway(), 40, true), HasSubstr("rmse 0.184"));
}

TEST(Progress, AsciiTerminalsGetAscii) {
  for (const char c : progress_bar_line(halfway(), 140, false)) EXPECT_GT(c, 0x1f);
}

TEST(Progress, BarIsEmptyAtTheStartAndFullAtTheEnd) {
  TrainProgress progress = halfway();
  progress.step = 0;
  EXPECT_THAT(progress_bar_line(progress, 140, false), HasSubstr("[" + std::string(30, '.') + "]"));
  progress.step = progress.steps;
  EXPECT_THAT(progress_bar_line(progress, 140, false), HasSubstr("[" + std::string(30, '#') + "]"));
  progress.step = 2 * progress.steps;
  EXPECT_THAT(progress_bar_line(progress, 140, false), HasSubstr("[" + std::string(30, '#') + "]"));
}

TEST(Progress, ShowsUnknownNumbersAsAQuestionMarkAndNeverAsNan) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const TrainProgress unknown{0, 0, nan, nan, {}, nan, nan, nan};
  for (const std::string& line : {progress_bar_line(unknown, 100, true), progress_log_line(unknown, true)}) {
    EXPECT_THAT(line, HasSubstr("rmse ?"));
    EXPECT_THAT(line, Not(HasSubstr("nan")));
  }
}

TEST(Progress, ConjugatePairIsShownOnce) {
  EXPECT_EQ(eigenvalues_text({{-0.5, 2.0}, {-0.5, -2.0}, {-3.0, 0.0}}, true), "-0.50±2.0i, -3.0");
  EXPECT_EQ(eigenvalues_text({{-0.5, 2.0}}, false), "-0.50+-2.0i");
}

TEST(Progress, DurationsReadLikeAClock) {
  EXPECT_EQ(duration_text(8.4), "8 s");
  EXPECT_EQ(duration_text(59.6), "1:00");
  EXPECT_EQ(duration_text(125), "2:05");
  EXPECT_EQ(duration_text(3725), "1:02:05");
  EXPECT_EQ(duration_text(-1.0), "?");
}

TEST(Progress, LogHasOneLineForEachTenthAndBothEnds) {
  // 10,000 fast steps: the log has the first step, one step per tenth, and the last.
  const std::string text = written(ProgressDisplay::Mode::kLog, [](ProgressDisplay& display) {
    TrainProgress progress = halfway();
    progress.steps = 10'000;
    for (progress.step = 1; progress.step <= progress.steps; ++progress.step) display.update(progress);
  });
  EXPECT_EQ(count(text, '\n'), 11);
  EXPECT_EQ(count(text, '\r'), 0);
  EXPECT_EQ(count(text, '\x1b'), 0);
  EXPECT_THAT(text, HasSubstr("step 10000 of 10000"));
}

TEST(Progress, RedrawsOneLineOfATerminalAndEndsIt) {
  const std::string text = written(ProgressDisplay::Mode::kTerminal, [](ProgressDisplay& display) {
    TrainProgress progress = halfway();
    for (progress.step = 1; progress.step < progress.steps; ++progress.step) display.update(progress);
  });
  EXPECT_EQ(count(text, '\n'), 1);
  EXPECT_EQ(text.back(), '\n');
  EXPECT_LT(count(text, '\r'), 100);          // redrawn at fixed times, not at every step
  EXPECT_THAT(text, HasSubstr(" 999/1000"));  // the last state, even if the run was interrupted
}

TEST(Progress, WritesALogIfTheStreamIsAFile) {
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::tmpfile(), std::fclose);
  {
    ProgressDisplay display(file.get());
    display.update(halfway());
  }
  EXPECT_GT(std::ftell(file.get()), 0);
  std::rewind(file.get());
  EXPECT_EQ(std::fgetc(file.get()), 's');  // "step 500 of 1000"
}

}  // namespace
}  // namespace nlo::trainer
