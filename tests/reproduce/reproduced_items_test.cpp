// SPDX-License-Identifier: MIT
// The items of `nlo reproduce` and the trainings they share.
#include "trainer/reproduce/reproduced_items.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <utility>

#include "tests/support/thrown_message.h"
#include "trainer/app/jobs/kept_training.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/plants/initial_states.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/run_range.h"
#include "trainer/plants/simulate_runs.h"
#include "trainer/reproduce/planned_trainings.h"

namespace nlo::trainer::reproduction {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string refusal(const std::string& what) {
  return thrown_message([&] { select_items(what); });
}

TEST(Registry, CoversTheTablesAndFiguresOfThePaper) {
  std::set<std::string> labels;
  for (const Item& item : items()) labels.emplace(item.label);
  for (const char* label : {"luen-like", "vanderpol-rmse", "vanderpol-rmse-add", "vanderpol-compare",
                            "vanderpol-compare-without", "vanderpol-compare-reg", "reg-traj", "vanderpol-compare-no",
                            "compare_x_rmse", "compare_x12", "duff-exc", "osci-auto", "compare_pde"})
    EXPECT_TRUE(labels.contains(label)) << label;
}

TEST(Registry, EveryItemIsComplete) {
  std::set<std::string> names;
  for (const Item& item : items()) {
    EXPECT_TRUE(names.emplace(item.name).second) << item.name << " is listed twice";
    EXPECT_FALSE(item.title.empty() || item.label.empty() || item.paper_reports.empty()) << item.name;
    EXPECT_TRUE(item.example.starts_with("example") || item.example == "exams") << item.name;
    EXPECT_NE(item.analyse, nullptr) << item.name;
    EXPECT_FALSE(item.experiments.empty()) << item.name;
    for (const auto name : item.experiments)
      EXPECT_EQ(paper_draft(name, kFullSize, 2).experiment.seed, 2U) << item.name << " needs " << name;
  }
}

TEST(Registry, TrainsEveryExperimentThatTheProgramCarries) {
  std::set<std::string> trained;
  for (const Item& item : items())
    for (const auto name : item.experiments) trained.emplace(name.substr(0, name.find(' ')));
  for (const ShippedExperiment& shipped : experiment_texts()) {
    std::string name(shipped.name);
    if (name.starts_with("paper/")) name.erase(0, 6);
    EXPECT_TRUE(trained.contains(name)) << shipped.name;
  }
}

TEST(ExperimentsOfThePaper, AreCompleteAndStayInTheRangeOfTheirInitialStates) {
  for (const ShippedExperiment& shipped : experiment_texts()) {
    const std::string file = std::string(shipped.name) + ".toml";
    const DraftExperiment draft = parse_draft(shipped.text, file);
    if (draft.experiment.log) continue;  // the recipe derives the rest from the logs
    EXPECT_TRUE(draft.complete) << file;
    const Experiment e = parse_experiment(shipped.text, file);
    const auto plant = make_plant(*e.plant);
    EXPECT_THAT(range_warnings(simulate_runs(e, *plant, initial_state_seed(e.seed, SeedStream::kTraining), 8), e),
                testing::IsEmpty())
        << file;
  }
}

TEST(Registry, SelectsItemsByNameByExampleOrAll) {
  EXPECT_EQ(select_items("all").size(), items().size());
  ASSERT_EQ(select_items("table1").size(), 1U);
  EXPECT_EQ(select_items("table1").front()->name, "table1");
  for (const Item* item : select_items("example3")) EXPECT_EQ(item->example, "example3");
}

TEST(Registry, TheErrorForAnUnknownItemNamesTheNearest) {
  EXPECT_THAT(refusal("tabel1"), HasSubstr("did you mean \"table1\"?"));
  EXPECT_THAT(refusal("figure-vanderpol-compar"), HasSubstr("did you mean \"figure-vanderpol-compare\"?"));
  EXPECT_THAT(refusal("qqqq"), AllOf(HasSubstr("there are: all"), HasSubstr("table2")));
}

TEST(Jobs, EachExperimentAndSeedIsTrainedOnceForAllItems) {
  std::set<std::pair<std::string, int>> planned;
  std::set<std::uint64_t> hashes;
  const auto all = select_items("all");
  for (const PlannedTraining& job : plan_trainings(all, kFullSize, 2)) {
    EXPECT_TRUE(planned.emplace(job.experiment, job.seed).second) << job.experiment << " is planned twice";
    EXPECT_TRUE(hashes.insert(run_identity(job.draft.experiment)).second)
        << job.experiment << ": its hash is that of another job";
  }
  for (const Item* item : all)
    for (const auto name : item->experiments)
      for (int seed = 0; seed < 2; ++seed) EXPECT_TRUE(planned.contains({std::string(name), seed})) << name;
}

TEST(Jobs, QuickTrainsFewerSteps) {
  const Experiment full = paper_draft("van_der_pol_fast", kFullSize, 1).experiment;
  const Experiment quick = paper_draft("van_der_pol_fast", kQuickSize, 1).experiment;
  EXPECT_EQ(quick.training.steps, full.training.steps / 4);
  EXPECT_NE(run_identity(quick), run_identity(full));
}

TEST(Jobs, LeaveTheStructureAndTheStepsOfSilverboxToTheRecipe) {
  const DraftExperiment full = paper_draft("exams/silverbox", kFullSize, 2);
  EXPECT_FALSE(full.complete);
  EXPECT_FALSE(full.given.has("observer.structure"));
  EXPECT_FALSE(full.given.has("training.steps"));
  EXPECT_TRUE(paper_draft("exams/silverbox", kQuickSize, 2).given.has("training.steps"));
}

}  // namespace
}  // namespace nlo::trainer::reproduction
