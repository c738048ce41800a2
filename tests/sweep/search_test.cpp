// SPDX-License-Identifier: MIT
#include "trainer/app/sweep/search.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "trainer/base/draws.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/shipped.h"
#include "trainer/structures/structure_table.h"

namespace nlo::trainer {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::IsSubsetOf;
using testing::Not;

Experiment shipped(std::string_view name) {
  for (const ShippedExperiment& each : shipped_experiments())
    if (each.name == name) return parse_experiment(each.text, std::string(name));
  throw std::logic_error("no such experiment");
}

std::set<std::string> structures_of(const Experiment& base, int draws) {
  std::set<std::string> found;
  for (int index = 1; index <= draws; ++index)
    if (const auto drawn = drawn_experiment(base, 0.02, static_cast<std::uint64_t>(index)))
      found.insert(drawn->observer.structure);
  return found;
}

TEST(Draws, AreRoundedToThreeDigits) {
  EXPECT_EQ(rounded(0.123456), 0.123);
  EXPECT_EQ(rounded(-987.65), -988.0);
  EXPECT_EQ(rounded(3e-9), 3e-9);
  EXPECT_EQ(rounded(0.0), 0.0);
  EXPECT_EQ(rounded(2.9999e5), 3e5);
}

TEST(Draws, ChooseEachValueEquallyOften) {
  Draws draws(7);
  std::vector<int> counts(5);
  for (int i = 0; i < 5000; ++i) ++counts[draws.below(5)];
  for (const int count : counts) EXPECT_NEAR(count, 1000, 140) << "five standard deviations of a fair draw";
}

TEST(Draws, GiveWidthsInMultiplesOfEightAndFourLayersAtMost) {
  Draws draws(3);
  std::vector<int> hidden = {24, 24};
  std::set<std::size_t> layers;
  for (int i = 0; i < 300; ++i) {
    vary_widths(hidden, draws);
    layers.insert(hidden.size());
    for (const int width : hidden) {
      EXPECT_EQ(width % 8, 0);
      EXPECT_GE(width, 8);
      EXPECT_LE(width, 1024);
    }
  }
  EXPECT_THAT(layers, testing::ElementsAre(1U, 2U, 3U, 4U)) << "control: layers are added and removed";
}

TEST(Search, BeginsWithTheUnchangedExperiment) {
  const Experiment base = shipped("van_der_pol");
  const auto first = drawn_experiment(base, 0.02, 0);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->source_text, base.source_text);
  EXPECT_EQ(difference(base, *first).full, "");
}

TEST(Search, IsReproducible) {
  const Experiment base = shipped("van_der_pol");
  for (std::uint64_t index = 1; index < 20; ++index) {
    const auto one = drawn_experiment(base, 0.02, index), other = drawn_experiment(base, 0.02, index);
    ASSERT_EQ(one.has_value(), other.has_value());
    if (one) {
      EXPECT_EQ(one->source_text, other->source_text);
    }
  }
}

// A search must not change the plant, the data, the noise or the loss.
TEST(Search, KeepsPlantDataNoiseAndLoss) {
  for (const char* name : {"van_der_pol", "van_der_pol_gated", "qube", "battery", "car", "van_der_pol_general"}) {
    const Experiment base = shipped(name);
    int drawn = 0;
    for (std::uint64_t index = 1; index <= 40; ++index) {
      const auto other = drawn_experiment(base, 0.01, index);
      if (!other) continue;
      ++drawn;
      EXPECT_EQ(difference(base, *other).full.empty(), other->source_text == base.source_text) << name << index;
      EXPECT_EQ(other->source_text, parse_experiment(other->source_text, "again").source_text);
      for (const char* section : {"plant.", "simulation.", "excitation.", "loss.", "evaluation.", "training.noise",
                                  "training.mirror", "training.dropout", "name", "seed"})
        EXPECT_THAT(", " + difference(base, *other).full, Not(HasSubstr(std::string(", ") + section))) << name << index;
      if (base.log) {
        EXPECT_EQ(other->log->train_files, base.log->train_files);
      }
    }
    EXPECT_GT(drawn, 10) << name << ": control: most draws can be trained; with an angle as output, not all";
  }
}

TEST(Search, TriesOtherStructuresThatFitThePlant) {
  EXPECT_THAT(structures_of(shipped("van_der_pol"), 60), testing::UnorderedElementsAre("kkl", "gated", "prior"));
  EXPECT_THAT(structures_of(shipped("van_der_pol_gated"), 60), testing::UnorderedElementsAre("kkl", "gated", "prior"));
  EXPECT_THAT(structures_of(shipped("qube"), 60), Contains("kkl"));
}

// Matrices of a plant, and an input field, can only come from the user.
TEST(Search, KeepsAStructureThatNeedsKnowledgeOfThePlant) {
  const std::string paper = NLO_SOURCE_DIR "/trainer/experiments/paper/";
  EXPECT_THAT(structures_of(read_experiment(paper + "example1.toml"), 60), testing::ElementsAre("luenberger"));
  EXPECT_THAT(structures_of(read_experiment(paper + "reverse_duffing_driven.toml"), 60),
              testing::ElementsAre("driven_kkl"));
}

TEST(Search, VariesTimeScalesWidthsAndRates) {
  const Experiment base = shipped("van_der_pol");
  std::string all;
  for (std::uint64_t index = 1; index <= 60; ++index)
    if (const auto drawn = drawn_experiment(base, 0.02, index)) all += difference(base, *drawn).full + "\n";
  EXPECT_THAT(all, AllOf(HasSubstr("observer.eigenvalues"), HasSubstr("observer.pairs"), HasSubstr("observer.clocks_s"),
                         HasSubstr("inverse_map.hidden"), HasSubstr("training.learning_rate"),
                         HasSubstr("training.eigenvalue_learning_rate"), HasSubstr("observer.units = ")));
}

TEST(Search, NamesTheDifferencesOfACandidate) {
  const Experiment base = shipped("van_der_pol");
  Experiment other = base;
  other.inverse_map.hidden = {16};
  other.training.learning_rate = 0.25;
  other.training.steps = 3;
  other.source_text = format_experiment(other);
  EXPECT_EQ(difference(base, other).full, "inverse_map.hidden = [16], training.learning_rate = 0.25");
  EXPECT_EQ(difference(base, other).title, "hidden=[16] learning_rate=0.25");
}

TEST(Search, ValidatesShortTrainingsTwentyTimes) {
  Experiment experiment = shipped("van_der_pol");
  set_steps(experiment, 200);
  EXPECT_EQ(experiment.training.steps, 200);
  EXPECT_EQ(experiment.training.validate_every, 10);
  EXPECT_EQ(parse_experiment(experiment.source_text, "again").training.steps, 200);
  const int every = shipped("van_der_pol").training.validate_every;
  experiment = shipped("van_der_pol");
  set_steps(experiment, 1000 * every);
  EXPECT_EQ(experiment.training.validate_every, every) << "a shorter validation interval is kept";
  set_steps(experiment, 1);
  EXPECT_EQ(experiment.training.validate_every, 1);
}

TEST(Halving, SpendsTheGivenTime) {
  for (const std::size_t candidates : {1U, 2U, 4U, 7U, 16U, 64U}) {
    const std::vector<Rung> rungs = halving_rungs(candidates, 300.0);
    double seconds = rungs.back().seconds;  // training time of the winner
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

TEST(Halving, KeepsTheBestQuarterOfARung) {
  std::vector<std::size_t> sizes;
  for (const Rung& rung : halving_rungs(64, 1.0)) sizes.push_back(rung.candidates);
  EXPECT_THAT(sizes, ElementsAre(64, 16, 4, 2));
}

TEST(Halving, TriesMoreCandidatesInMoreTime) {
  EXPECT_EQ(candidates_for(0.1, 0.0), 4U) << "minimum";
  EXPECT_EQ(candidates_for(1e6, 0.0), 64U) << "maximum";
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
  EXPECT_GE(halving_rungs(candidates_for(600.0, 5.0), 600.0).front().seconds, 15.0)
      << "most of the time is training, not setting up";
}

TEST(Halving, ComputesTheMinutesForANumberOfSteps) {
  for (const TrainingPace pace : {TrainingPace{0.0, 100.0}, TrainingPace{20.0, 100.0}, TrainingPace{1.0, 3.0}}) {
    const double steps = 3000.0, minutes = minutes_for(pace, steps);
    const auto steps_of = [&](double m) {
      const double seconds = 0.8 * 60.0 * m;
      return steps_within(pace, halving_rungs(candidates_for(seconds, pace.setup_s), seconds).back().seconds);
    };
    EXPECT_GE(steps_of(minutes), steps);
    EXPECT_LT(steps_of(0.8 * minutes), steps) << "the smallest such time: " << minutes;
  }
  EXPECT_EQ(steps_within({5.0, 10.0}, 20.0), 150.0);
  EXPECT_EQ(steps_within({19.0, 10.0}, 20.0), 50.0) << "a quarter of the time is always left for training";
}

TEST(Halving, RanksCandidatesByTheirError) {
  EXPECT_THAT(best_of({3.0, std::nullopt, 1.0, 2.0, 1.0}, 3), ElementsAre(2, 4, 3));
  EXPECT_THAT(best_of({std::nullopt, 5.0}, 2), ElementsAre(1)) << "a diverged candidate is never continued";
  EXPECT_THAT(best_of({std::nullopt}, 1), IsEmpty());
}

}  // namespace
}  // namespace nlo::trainer
