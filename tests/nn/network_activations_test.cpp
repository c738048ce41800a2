// SPDX-License-Identifier: MIT
// Each activation in the parts of the trainer that network_test.cpp, network_tangents_test.cpp and the tests of bounds
// (tests/bounds), which run over the same table, do not cover.
#include "codegen/model/activations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "trainer/config/experiment.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/gradients/nn/block_activation.h"
#include "trainer/gradients/nn/network_block.h"
#include "trainer/structures/structure.h"

namespace nlo::trainer {
namespace {

using ::testing::HasSubstr;

std::string experiment_with(const std::string& section, const std::string& activation) {
  return "name = \"small\"\n[plant]\nmodel = \"van_der_pol\"\n[simulation]\ninitial_low = [-1, -1]\n"
         "initial_high = [1, 1]\n[observer]\neigenvalues = [-1.0, -2.0]\n[" +
         section + "]\nactivation = \"" + activation + "\"\n";
}

class EachTrainedActivation : public ::testing::TestWithParam<std::string> {
 protected:
  const codegen::ActivationRow& row() const { return codegen::activation_named(GetParam()); }
};
INSTANTIATE_TEST_SUITE_P(Activations, EachTrainedActivation, ::testing::ValuesIn(codegen::activation_names()),
                         [](const auto& named) { return named.param; });

TEST_P(EachTrainedActivation, IsAcceptedByEveryNetworkAndSetsItsShape) {
  for (const char* section : {"inverse_map", "forward_map", "dynamics"})
    EXPECT_NO_THROW(parse_experiment(experiment_with(section, GetParam()), "small.toml", {})) << section;
  const Experiment experiment = parse_experiment(experiment_with("inverse_map", GetParam()), "small.toml", {});
  EXPECT_EQ(experiment.inverse_map.activation, GetParam());
  EXPECT_THAT(format_experiment(experiment), HasSubstr("activation = \"" + GetParam() + "\""));
  const codegen::Channel channel{.name = "x", .unit = "", .wrap = 0.0};
  const ObserverStructure structure = make_structure(experiment, false, {channel}, {channel, channel});
  EXPECT_EQ(structure.network.activation, row().kind);
}

/// In double, a block uses the functions of the table; in float, those of the runtime.
TEST_P(EachTrainedActivation, TrainsWithTheFunctionsOfTheTable) {
  codegen::with_trained_activation(row().kind, [&](auto kind) {
    using Activated = BlockActivation<kind()>;
    for (double v = -9.0; v <= 9.0; v += 0.0625) {
      if (row().kink_at_zero && v == 0.0) continue;
      const double a = Activated::value(v), input = row().slope_needs_input ? v : a;
      EXPECT_NEAR(a, row().value(v), 1e-14) << v;
      EXPECT_NEAR(Activated::slope(input, a), row().slope(v), 1e-14) << v;
      EXPECT_NEAR(Activated::curvature(input, a), row().curvature(v), 1e-14) << v;
      const auto narrow = static_cast<float>(v);
      EXPECT_NEAR(static_cast<double>(Activated::value(narrow)), row().value(v), (1.0 + std::abs(v)) * kTanhMaxError);
    }
  });
}

TEST(Activations, ActivationsForExportsOnlyAreRefusedInTraining) {
  for (const codegen::ActivationRow& row : codegen::kActivations) {
    if (row.is_trained()) continue;
    EXPECT_THROW(parse_experiment(experiment_with("inverse_map", std::string(row.name)), "small.toml", {}),
                 codegen::Error);
    const NetworkShape shape = NetworkShape::make({2, 3, 1}, row.kind, false);
    WideBlock block(shape);
    const std::vector<float> parameters(static_cast<std::size_t>(shape.parameters));
    EXPECT_THROW(block.forward(parameters.data()), codegen::Error)
        << "without an error, the output would stay unchanged";
  }
}

}  // namespace
}  // namespace nlo::trainer
