// SPDX-License-Identifier: MIT
// The HyperKKL benchmark: its random inputs, its published errors, and the comparison with them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "trainer/plants/run_random.h"
#include "trainer/reproduce/contest.h"
#include "trainer/reproduce/hyperkkl_cells.h"
#include "trainer/reproduce/planned_trainings.h"

namespace nlo::trainer::reproduction {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

RunRandom numbers() {
  return {7, RunPurpose::kInputs, 0, 0};
}

TEST(HyperKkl, InputsAreDrawnWithinTheDeclaredRanges) {
  RunRandom random = numbers();
  for (const InputRange& range : kKnownInputs) {
    double least = 1e9, most = -1e9, slowest = 1e9, fastest = -1e9;
    for (int i = 0; i < 500; ++i) {
      const DrivenInput u = draw_input(range, random);
      least = std::min(least, u.amplitude);
      most = std::max(most, u.amplitude);
      slowest = std::min(slowest, u.frequency);
      fastest = std::max(fastest, u.frequency);
    }
    const double margin = 0.05;  // 500 draws come near both ends
    EXPECT_TRUE(range.least <= least && least <= range.least + margin * (range.most - range.least)) << range.title;
    EXPECT_TRUE(range.most - margin * (range.most - range.least) <= most && most <= range.most) << range.title;
    EXPECT_TRUE(range.slowest <= slowest && fastest <= range.fastest) << range.title;
  }
  const DrivenInput one = draw_input(kFarInputs[0], random), other = draw_input(kFarInputs[0], random);
  EXPECT_EQ(std::abs(one(3.0)), 2.0);
  EXPECT_EQ(std::abs(other(3.0)), 2.0);
}

TEST(HyperKkl, InputsEqualTheirFormulas) {
  const DrivenInput zero{InputSignal::kZero, 1.0, 1.0}, constant{InputSignal::kConstant, -0.4};
  const DrivenInput sine{InputSignal::kSine, 0.5, 2.0, 0.3}, square{InputSignal::kSquare, 0.5, 2.0};
  for (const double t : {0.0, 0.4, 1.7, 20.0}) {
    EXPECT_EQ(zero(t), 0.0);
    EXPECT_EQ(constant(t), -0.4);
    EXPECT_DOUBLE_EQ(sine(t), 0.5 * std::sin(2.0 * t + 0.3));
  }
  EXPECT_EQ(square(0.0), 0.0);
  EXPECT_EQ(square(0.25 * std::numbers::pi), 0.5);
  EXPECT_EQ(square(0.75 * std::numbers::pi), -0.5);
}

TEST(HyperKkl, ALatinHypercubeHasOneStartInEachSliceOfEachState) {
  SimulationConfig box;
  box.initial_low = {-1.0, 0.0};
  box.initial_high = {1.0, 10.0};
  constexpr Eigen::Index kCount = 20;
  RunRandom random = numbers();
  const Eigen::MatrixXd x = latin_hypercube(box, kCount, random);
  for (Eigen::Index i = 0; i < 2; ++i) {
    std::vector<int> hits(kCount, 0);
    const double low = box.initial_low[static_cast<std::size_t>(i)];
    const double width = (box.initial_high[static_cast<std::size_t>(i)] - low) / static_cast<double>(kCount);
    for (Eigen::Index run = 0; run < kCount; ++run) ++hits.at(static_cast<std::size_t>((x(i, run) - low) / width));
    EXPECT_THAT(hits, testing::Each(1));
  }
}

TEST(HyperKkl, ComparesWithThePublishedNumbers) {
  EXPECT_THAT(kBenchmarkPlants[0].published, ElementsAre(5.6, 21.1, 22.7, 21.3));   // Duffing
  EXPECT_THAT(kBenchmarkPlants[1].published, ElementsAre(5.0, 26.0, 15.5, 17.9));   // Van der Pol
  EXPECT_THAT(kBenchmarkPlants[2].published, ElementsAre(52.7, 55.4, 53.5, 54.0));  // Roessler
  EXPECT_THAT(kBenchmarkPlants[3].published, ElementsAre(9.8, 42.1, 30.9, 32.5));   // FitzHugh-Nagumo
}

TEST(HyperKkl, ExperimentsTrainOnTheBenchmarksInputs) {
  for (const BenchmarkPlant& plant : kBenchmarkPlants) {
    const Experiment experiment = paper_draft(plant.experiment, kFullSize, 1).experiment;
    ASSERT_TRUE(experiment.excitation) << plant.title;
    EXPECT_THAT(experiment.excitation->kinds,
                ElementsAre(InputSignal::kZero, InputSignal::kConstant, InputSignal::kSine, InputSignal::kSquare));
    EXPECT_THAT(experiment.excitation->amplitude, ElementsAre(0.1, 1.0));
    EXPECT_NEAR(experiment.excitation->shortest_s, 2.0 * std::numbers::pi / 3.0, 1e-12);
    EXPECT_NEAR(experiment.excitation->longest_s, 2.0 * std::numbers::pi / 0.5, 1e-12);
    EXPECT_EQ(experiment.simulation.sample_period_s, 0.05);
    for (std::size_t i = 0; i < experiment.simulation.initial_high.size(); ++i)
      EXPECT_EQ(experiment.simulation.initial_high[i], plant.high[i]) << plant.title;
  }
}

TEST(Contest, IsAheadOnlyIfTheWorstSeedIs) {
  const Contender ahead{"a", "x", 5.0, {4.0, 4.9}, {1.0, 2.0}}, behind{"b", "x, y", 5.0, {4.0, 5.1}, {1.0, 2.0}};
  const Contender beside{"c", "x", {}, {1.0, 2.0}, {1.0, 2.0}};
  EXPECT_TRUE(is_ahead(ahead, ahead.components));
  EXPECT_FALSE(is_ahead(behind, behind.components));
  EXPECT_FALSE(is_ahead(beside, beside.components));
  const Contest contest{"t", {ahead, behind, beside}};
  EXPECT_EQ(contest_score(contest), "1 of 2 cells ahead by components, 2 of 2 by norms");
  EXPECT_THAT(contest_text(contest), HasSubstr("behind"));
  const std::string csv = contests_csv({contest});
  EXPECT_THAT(csv, HasSubstr("table,row,column,reading,metric,paper,mean,deviation,relative_to_paper,seed_1,seed_2\n"));
  EXPECT_THAT(csv, HasSubstr("t,b,\"x, y\",components,smape,5,4.55,"));
}

}  // namespace
}  // namespace nlo::trainer::reproduction
