// SPDX-License-Identifier: MIT
// Properties of each built-in plant. A line in the registry is enough to test a new plant.
#include "trainer/plants/plant_registry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "codegen/base/error.h"
#include "codegen/base/identifier.h"
#include "tests/support/thrown_message.h"
#include "trainer/plants/plant_form.h"
#include "trainer/plants/simulate.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;

class EveryPlant : public testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<Plant> plant() const {
    PlantConfig config;
    config.model = GetParam();
    return make_plant(config);
  }
  SimulationConfig unit_box(const Plant& p) const {
    SimulationConfig config;
    config.initial_low.assign(p.states().size(), -1.0);
    config.initial_high.assign(p.states().size(), 1.0);
    config.horizon_s = 4.0;
    return config;
  }
};

TEST_P(EveryPlant, HasItsNameAndValidChannelNames) {
  const auto p = plant();
  EXPECT_EQ(p->name(), GetParam());
  EXPECT_TRUE(codegen::is_identifier(p->name()));
  for (const auto& channel : p->states()) EXPECT_TRUE(codegen::is_identifier(channel.name)) << channel.name;
  for (const auto& channel : p->outputs()) EXPECT_TRUE(codegen::is_identifier(channel.name)) << channel.name;
  for (const auto& channel : p->inputs()) EXPECT_TRUE(codegen::is_identifier(channel.name)) << channel.name;
}

TEST_P(EveryPlant, HasTheSameDerivativeForABatchAsForEachColumn) {
  const auto p = plant();
  const Eigen::MatrixXd x = 2.0 * Eigen::MatrixXd::Random(p->nx(), 13);
  const Eigen::MatrixXd dx = p->derivative(x), y = p->output(x);
  ASSERT_EQ(dx.rows(), p->nx());
  ASSERT_EQ(y.rows(), p->ny());
  // The last bit of Eigen's vectorised sine may differ from that of the scalar one.
  constexpr double kVectorRounding = 1e-14;
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    EXPECT_LE((p->derivative(x.col(i)) - dx.col(i)).cwiseAbs().maxCoeff(), kVectorRounding);
    EXPECT_LE((p->output(x.col(i)) - y.col(i)).cwiseAbs().maxCoeff(), kVectorRounding);
  }
  for (Eigen::Index j = 0; j < p->nu(); ++j) {
    const Eigen::MatrixXd g = p->input_field(x, j);
    ASSERT_EQ(g.rows(), p->nx());
    ASSERT_EQ(g.cols(), x.cols());
    for (Eigen::Index i = 0; i < x.cols(); ++i)
      EXPECT_LE((p->input_field(x.col(i), j) - g.col(i)).cwiseAbs().maxCoeff(), kVectorRounding);
  }
}

TEST_P(EveryPlant, IsSimulatedAtFourthOrder) {
  const auto p = plant();
  SimulationConfig config = unit_box(*p);
  const Eigen::MatrixXd initial = draw_initial_states(config, 3, 8);
  const auto order = [&](const Excitation& excitation) {
    const auto final_states = [&](double h) {
      config.sample_period_s = h;
      const Dataset d = simulate_from(*p, config, initial, excitation);
      Eigen::MatrixXd x(p->nx(), initial.cols());
      for (Eigen::Index i = 0; i < x.cols(); ++i)
        x.col(i) = d.trajectories[static_cast<std::size_t>(i)].states.rightCols<1>();
      return x;
    };
    const Eigen::MatrixXd reference = final_states(0.0025);
    const double coarse = (final_states(0.08) - reference).norm(), fine = (final_states(0.04) - reference).norm();
    EXPECT_GT(coarse, 1e-9);  // otherwise rounding hides the order
    return std::log2(coarse / fine);
  };
  EXPECT_NEAR(order({}), 4.0, 0.35);
  if (p->nu() == 0) return;
  EXPECT_NEAR(order([&](double t) { return Eigen::VectorXd::Constant(p->nu(), std::cos(3.0 * t)); }), 4.0, 0.35);
}

TEST_P(EveryPlant, HasAnAffineInputFieldOrNoInput) {
  const auto p = plant();
  const Eigen::VectorXd one = Eigen::VectorXd::Ones(p->nx());
  if (p->nu() == 0) {
    EXPECT_THROW(affine_input_field(*p, -one, one), codegen::Error);
    return;
  }
  const codegen::DenseLayer field = affine_input_field(*p, -one, one);
  const Eigen::MatrixXd x = Eigen::MatrixXd::Random(p->nx(), 5);
  for (Eigen::Index j = 0; j < p->nu(); ++j) {
    const Eigen::MatrixXd g =
        (field.weights * x).middleRows(j * p->nx(), p->nx()).colwise() + field.bias.segment(j * p->nx(), p->nx());
    EXPECT_LE((g - p->input_field(x, j)).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST_P(EveryPlant, RefusesAnUnknownParameter) {
  PlantConfig config;
  config.model = GetParam();
  config.parameters = {{"no_such_parameter", 1.0}};
  EXPECT_THROW(make_plant(config), codegen::Error);
}

std::vector<std::string> names() {
  std::vector<std::string> result;
  for (const PlantEntry& entry : plant_registry()) result.emplace_back(entry.name);
  return result;
}
INSTANTIATE_TEST_SUITE_P(Registry, EveryPlant, testing::ValuesIn(names()),
                         [](const auto& plant) { return plant.param; });

TEST(PlantRegistry, SuggestsTheNearestName) {
  PlantConfig config;
  config.model = "van_der_pole";
  EXPECT_THAT(thrown_message([&] { make_plant(config); }), HasSubstr("did you mean \"van_der_pol\"?"));
}

TEST(PlantRegistry, ParametersChangeThePlant) {
  PlantConfig config;
  config.model = "van_der_pol";
  const Eigen::MatrixXd x = Eigen::Vector2d(0.5, 2.0);
  EXPECT_DOUBLE_EQ(make_plant(config)->derivative(x)(1, 0), 0.75 * 2.0 - 0.5);
  config.parameters = {{"mu", 3.0}};
  EXPECT_DOUBLE_EQ(make_plant(config)->derivative(x)(1, 0), 3.0 * 0.75 * 2.0 - 0.5);
}

}  // namespace
}  // namespace nlo::trainer
