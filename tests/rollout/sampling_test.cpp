// SPDX-License-Identifier: MIT
// The segments of the runs that a training step draws.
#include "trainer/rollout/sampling.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>

#include "codegen/base/error.h"
#include "tests/support/mirrored.h"
#include "tests/training/training_testing.h"
#include "trainer/experiments/load_experiment.h"

namespace nlo::trainer {
namespace {

Experiment with(const std::string& training) {
  return parse_experiment(
      "name = \"s\"\n[plant]\nmodel = \"van_der_pol\"\n[simulation]\nhorizon_s = 50.0\ninitial_low = [-1.0, -1.0]\n"
      "initial_high = [1.0, 1.0]\n[observer]\neigenvalues = [-1.0]\n[training]\nsteps = 100\n" +
          training,
      "s.toml");
}

std::vector<Segment> drawn(const std::string& training, long step) {
  static const Dataset kRuns = testing::harmonics({400, 600}, false);  // 20 and 30 s
  static const TrainingData kData(kRuns), kMirrored(testing::mirrored(kRuns));
  const Experiment experiment = with("trajectories_per_step = 400\nsegment_s = 5.0\n" + training);
  return draw_segments(experiment, experiment.training.mirror ? kMirrored : kData, step);
}

TEST(Segments, GrowFromTheirFirstToTheirFullLengthInHalfOfTheSteps) {
  for (const auto& [step, seconds] : {std::pair{0L, 1.0}, {25L, 3.0}, {50L, 5.0}, {75L, 5.0}, {99L, 5.0}})
    for (const Segment& segment : drawn("first_segment_s = 1.0\n", step))
      ASSERT_EQ(segment.length, std::lround(seconds / 0.05) + 1) << step;
  for (const Segment& segment : drawn("", 0)) ASSERT_EQ(segment.length, 101) << "control: without the key";
}

TEST(Segments, BeginAtTheFirstSampleInTheirShare) {
  const auto at_zero = [](const std::string& training) {
    int count = 0;
    for (const Segment& segment : drawn(training, 3)) count += segment.start == 0 ? 1 : 0;
    return count;
  };
  EXPECT_LT(at_zero(""), 10) << "control: without the key, one in 300 or 500 by chance";
  EXPECT_NEAR(at_zero("first_share = 0.4\n"), 160, 40);  // 4 standard deviations of 9.8
  EXPECT_EQ(at_zero("first_share = 1.0\n"), 400);
}

TEST(Segments, AreMirroredWithProbabilityOneHalfOnlyIfTheKeyIsSet) {
  constexpr int kSteps = 50, kSegments = 400;
  constexpr double kDraws = kSteps * kSegments, kDeviation = 0.5;  // for one draw of probability 1/2
  int mirrored = 0, alike = 0;
  bool before = false;
  for (int step = 0; step < kSteps; ++step)
    for (const Segment& segment : drawn("mirror = true\n", step)) {
      const bool turned = segment.mirrored;
      mirrored += turned;
      alike += turned == before;
      before = turned;
    }
  EXPECT_NEAR(mirrored, kDraws / 2.0, 4.0 * kDeviation * std::sqrt(kDraws));
  EXPECT_NEAR(alike, kDraws / 2.0, 4.0 * kDeviation * std::sqrt(kDraws)) << "each segment is drawn independently";
  for (const Segment& segment : drawn("", 0)) ASSERT_FALSE(segment.mirrored);
}

TEST(Segments, OfRunsWithProcessNoiseFormGroupsOfTheirOwn) {
  constexpr int kSteps = 200;
  constexpr std::size_t kGroups = 4;
  static const TrainingData kData(testing::harmonics(std::vector<int>(40, 400), false));
  const auto mixed_and_noisy = [](const std::string& share) {
    const Experiment e = parse_experiment(with("trajectories_per_step = 32\n").source_text, "s.toml",
                                          {"simulation.process_noise=[0.1, 0.1]", share});
    SimulationConfig quarter = e.simulation;
    quarter.process_noise_share = 0.25;
    int mixed = 0;
    std::array<int, kGroups> noisy{};
    for (int step = 0; step < kSteps; ++step) {
      const std::vector<Segment> segments = draw_segments(e, kData, step);
      for (std::size_t g = 0; g < kGroups; ++g) {
        int count = 0;
        for (std::size_t i = 0; i < kGroup; ++i)
          count += quarter.has_process_noise(static_cast<std::uint64_t>(segments[kGroup * g + i].run));
        noisy[g] += count;
        mixed += count > 0 && count < kGroup;
      }
    }
    return std::pair(mixed, noisy);
  };
  const auto [mixed, noisy] = mixed_and_noisy("simulation.process_noise_share=0.25");
  EXPECT_LE(mixed, kSteps) << "one group in a step has segments of both kinds";
  // 25 % of 1600 segments. Whole groups of 8 are drawn, so the standard deviation is about sqrt(1600 * 8 * 0.19) = 49.
  for (const int in_place : noisy) EXPECT_NEAR(in_place, 400, 200) << "no group of a step has them more often";
  EXPECT_GT(mixed_and_noisy("simulation.process_noise_share=1").first, 3 * kSteps) << "control: not gathered";
}

TEST(Segments, RefuseKeysOfRandomSegmentsIfTheyAreNotRandom) {
  for (const std::string key : {"first_segment_s = 1.0", "first_share = 0.5"}) try {
      with(key + "\n");
      ADD_FAILURE() << key;
    } catch (const codegen::Error& error) {
      EXPECT_EQ(std::string(error.what()).find("s.toml:12: [training] first_segment_s and first_share apply to"), 0U)
          << error.what();
    }
  EXPECT_THROW(with("segment_s = 5.0\nfirst_segment_s = 6.0\n"), codegen::Error);
}

}  // namespace
}  // namespace nlo::trainer
