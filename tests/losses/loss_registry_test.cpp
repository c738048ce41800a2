// SPDX-License-Identifier: MIT
// Properties of every loss: a key with a help text, checks of its requirements, a value.
#include "trainer/learn/losses/loss_registry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "codegen/base/error.h"
#include "trainer/experiments/load_experiment.h"

namespace nlo::trainer {
namespace {

using ::testing::HasSubstr;

std::string experiment_with(std::string_view term, const std::string& observer) {
  return "name = \"small\"\n[plant]\nmodel = \"van_der_pol\"\n[simulation]\ninitial_low = [-1, -1]\n"
         "initial_high = [1, 1]\n[observer]\n" +
         observer + "\n[loss]\n" + std::string(term) + " = 0.25\n";
}

class EachLoss : public ::testing::TestWithParam<LossTerm> {};
INSTANTIATE_TEST_SUITE_P(Losses, EachLoss, ::testing::ValuesIn(loss_terms()),
                         [](const auto& term) { return std::string(term.param.name); });

TEST_P(EachLoss, HasAKeyAHelpTextAndALineInTheExperiment) {
  const std::string name(GetParam().name);
  const Experiment experiment = parse_experiment(experiment_with(name, "eigenvalues = [-1.0]"), "small.toml", {});
  EXPECT_EQ(experiment.loss.weight(name), 0.25);
  EXPECT_THAT(format_experiment(experiment), HasSubstr("\n" + name + " = 0.25\n"));
  EXPECT_FALSE(GetParam().meaning.empty());
  EXPECT_THAT(describe_experiment_keys(), HasSubstr(std::string(GetParam().meaning)));
  EXPECT_EQ(needs_forward_map(experiment.loss), GetParam().needs_forward_map);
  EXPECT_EQ(needs_equations(experiment.loss), GetParam().needs_equations);
}

TEST_P(EachLoss, IsRefusedWhereTheObserverHasNoEigenvalues) {
  const std::string text = experiment_with(GetParam().name, "structure = \"general\"\neigenvalues = [-1.0]");
  if (GetParam().needs_eigenvalues) {
    EXPECT_THROW(parse_experiment(text, "small.toml", {}), codegen::Error);
  } else {
    EXPECT_NO_THROW(parse_experiment(text, "small.toml", {}));
  }
}

TEST_P(EachLoss, AloneTrainsEveryParameterUnlessItIsARegulariser) {
  const std::string text = experiment_with(GetParam().name, "eigenvalues = [-1.0]");
  const auto parse = [&] { parse_experiment(text, "small.toml", {"loss.state_error=0.0"}); };
  if (GetParam().name == "state_error") return;  // this loss is turned off below
  if (GetParam().is_regulariser()) {
    EXPECT_THROW(parse(), codegen::Error);
  } else {
    EXPECT_NO_THROW(parse());
  }
}

TEST(Losses, HaveUniqueNamesAndOnlyTheFirstIsOnByDefault) {
  std::set<std::string_view> names;
  for (const LossTerm& term : loss_terms()) EXPECT_TRUE(names.insert(term.name).second) << term.name;
  EXPECT_EQ(LossConfig().weight(loss_terms().front().name), 1.0);
}

TEST(Losses, PenaltyIsTheSquareOfAnEigenvalueWithItsSlope) {
  for (const LossTerm& term : loss_terms()) {
    const auto* penalty = std::get_if<EigenvalueLoss>(&term.form);
    if (penalty == nullptr) continue;
    double loss = 1.0;
    EXPECT_DOUBLE_EQ(penalty->add(0.5, -3.0, loss), -3.0);
    EXPECT_DOUBLE_EQ(loss, 1.0 + 0.5 * 9.0);
  }
}

}  // namespace
}  // namespace nlo::trainer
