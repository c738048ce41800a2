// SPDX-License-Identifier: MIT
#include "trainer/sweep/halving.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace nlo::trainer {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(Halving, SpendsTheTimeAndOneTrainingMore) {
  for (const std::size_t candidates : {1U, 2U, 4U, 7U, 16U, 64U}) {
    const std::vector<Rung> rungs = halving_rungs(candidates, 300.0);
    double seconds = rungs.back().seconds;  // of the winner
    for (const Rung& rung : rungs) seconds += static_cast<double>(rung.candidates) * rung.seconds;
    EXPECT_NEAR(seconds, 300.0, 1e-9);
    EXPECT_EQ(rungs.front().candidates, candidates);
    for (std::size_t r = 1; r < rungs.size(); ++r) {
      EXPECT_LT(rungs[r].candidates, rungs[r - 1].candidates);
      EXPECT_NEAR(static_cast<double>(rungs[r].candidates) * rungs[r].seconds,
                  static_cast<double>(rungs[0].candidates) * rungs[0].seconds, 1e-9)
          << "rungs take the same time";
    }
    EXPECT_LE(rungs.back().candidates, 2U);
  }
}

TEST(Halving, KeepsAQuarter) {
  std::vector<std::size_t> sizes;
  for (const Rung& rung : halving_rungs(64, 1.0)) sizes.push_back(rung.candidates);
  EXPECT_THAT(sizes, ElementsAre(64, 16, 4, 2));
}

TEST(Halving, TakesMoreCandidatesForMoreTime) {
  EXPECT_EQ(candidates_for(0.1, 0.0), 4U) << "so few at least";
  EXPECT_EQ(candidates_for(1e6, 0.0), 64U) << "so many at most";
  std::size_t before = 0;
  for (const double seconds : {10.0, 30.0, 100.0, 300.0}) {
    const std::size_t candidates = candidates_for(seconds, 0.0);
    EXPECT_GE(candidates, before);
    if (candidates > 4) {
      EXPECT_GE(halving_rungs(candidates, seconds).front().seconds, 2.0);
    }
    if (candidates < 64) {
      EXPECT_LT(halving_rungs(candidates + 1, seconds).front().seconds, 2.0);
    }
    before = candidates;
  }
  EXPECT_GE(halving_rungs(candidates_for(600.0, 5.0), 600.0).front().seconds, 15.0) << "setting up is not most of it";
}

TEST(Halving, NamesTheMinutesThatSufficeForSoManySteps) {
  for (const TrainingPace pace : {TrainingPace{0.0, 100.0}, TrainingPace{20.0, 100.0}, TrainingPace{1.0, 3.0}}) {
    const double steps = 3000.0, minutes = minutes_for(pace, steps);
    const auto steps_of = [&](double m) {
      const double seconds = 0.8 * 60.0 * m;
      return steps_within(pace, halving_rungs(candidates_for(seconds, pace.setup_s), seconds).back().seconds);
    };
    EXPECT_GE(steps_of(minutes), steps);
    EXPECT_LT(steps_of(0.8 * minutes), steps) << "and hardly more than that: " << minutes;
  }
  EXPECT_EQ(steps_within({5.0, 10.0}, 20.0), 150.0);
  EXPECT_EQ(steps_within({19.0, 10.0}, 20.0), 50.0) << "a quarter of the time at least";
}

TEST(Halving, TakesTheLeastErrorsInOrder) {
  EXPECT_THAT(best_of({3.0, std::nullopt, 1.0, 2.0, 1.0}, 3), ElementsAre(2, 4, 3));
  EXPECT_THAT(best_of({std::nullopt, 5.0}, 2), ElementsAre(1)) << "what diverged never goes on";
  EXPECT_THAT(best_of({std::nullopt}, 1), IsEmpty());
}

}  // namespace
}  // namespace nlo::trainer
