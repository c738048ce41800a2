// SPDX-License-Identifier: MIT
#include "trainer/filters/plant_equations.h"

#include <gtest/gtest.h>

#include "trainer/plants/registry.h"

namespace nlo::trainer {
namespace {

using Eigen::MatrixXd;

constexpr double kRounding = 1e-12;

PlantConfig builtin(std::string_view name) {
  PlantConfig config;
  config.model = name;
  return config;
}

TEST(PlantEquations, OfEachBuiltInPlantAreThePlant) {
  const MatrixXd x = MatrixXd::Random(2, 20), u = MatrixXd::Random(1, 20);
  for (const PlantEntry& entry : plant_registry()) {
    PlantConfig config = builtin(entry.name);
    for (const auto& [name, value] : entry.parameters) config.parameters.emplace_back(name, 1.3 * value);
    const auto plant = make_plant(config), written = make_plant(equations_of(config));
    EXPECT_LE((plant->derivative(x) - written->derivative(x)).norm(), kRounding) << entry.name;
    EXPECT_LE((plant->output(x) - written->output(x)).norm(), kRounding) << entry.name;
    ASSERT_EQ(plant->nu(), written->nu()) << entry.name;
    if (plant->nu() == 0) continue;
    EXPECT_LE((plant->driven_derivative(x, u) - written->driven_derivative(x, u)).norm(), kRounding) << entry.name;
  }
}

TEST(JointPlant, HasTheParametersOfEachPoint) {
  // mu acts linearly, omega by its square: differences of plants, and expressions.
  for (const auto& [model, name] : {std::pair{"van_der_pol", "mu"}, std::pair{"harmonic_oscillator", "omega"}}) {
    const LanePlant joint = joint_plant(builtin(model), {name}, MatrixXd::Random(2, 5));
    ASSERT_EQ(joint.nx, 3) << model;
    MatrixXd points(3, 4);
    points << MatrixXd::Random(2, 4), Eigen::RowVector4d(0.5, 1.0, 1.6, 3.0);
    const MatrixXd f = joint.f(points, MatrixXd());
    for (Eigen::Index i = 0; i < 4; ++i) {
      PlantConfig own = builtin(model);
      own.parameters = {{name, points(2, i)}};
      EXPECT_LE((f.col(i).head(2) - make_plant(own)->derivative(points.col(i).head(2))).norm(), kRounding) << model;
      EXPECT_EQ(f(2, i), 0.0) << model;
      EXPECT_EQ(joint.h(points, MatrixXd())(0, i), points(0, i)) << model;
    }
  }
}

}  // namespace
}  // namespace nlo::trainer
