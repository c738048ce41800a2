// SPDX-License-Identifier: MIT
// Properties of every kind of symmetry in the table: a new row is tested by standing there, with a plant that has it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "trainer/base/engine_draws.h"
#include "trainer/plants/plant_symmetry.h"
#include "trainer/plants/registry.h"
#include "trainer/plants/simulate.h"
#include "trainer/symmetry/symmetry.h"

namespace nlo::trainer {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kRounding = 1e-12;

/// A plant that has a symmetry of this kind.
struct Example {
  PlantConfig plant;
  SymmetryConfig symmetry;
};

PlantConfig plant_of(std::vector<std::string> states, std::vector<std::string> derivative,
                     std::vector<std::string> names, std::vector<std::string> outputs) {
  PlantConfig plant;
  plant.states = std::move(states);
  plant.derivative = std::move(derivative);
  plant.output_names = std::move(names);
  plant.outputs = std::move(outputs);
  return plant;
}

const std::map<std::string, Example, std::less<>>& examples() {
  static const std::map<std::string, Example, std::less<>> all = [] {
    constexpr double kTurn = 6.283185307179586;
    std::map<std::string, Example, std::less<>> list;
    list["sign"] = {plant_of({"p", "v"}, {"v", "(1 - p^2) * v - p"}, {"y"}, {"p"}),
                    {.kind = "sign", .channels = {"p", "v", "y"}}};
    // A particle in the field of the origin, which knows the way it points; and how fast it is.
    PlantConfig planar = plant_of(
        {"x", "y", "a"},
        {"0.4 * y - 0.1 * x * (x^2 + y^2)", "-0.4 * x - 0.1 * y * (x^2 + y^2)", "0.3 * (x * cos(a) + y * sin(a))"},
        {"mx", "my", "b"}, {"x - 0.2 * cos(a)", "y - 0.2 * sin(a)", "a"});
    planar.state_wraps = {0.0, 0.0, kTurn};
    planar.output_wraps = {0.0, 0.0, kTurn};
    list["rotation2"] = {planar, {.kind = "rotation2", .vectors = {{"x", "y"}, {"mx", "my"}}, .channels = {"a", "b"}}};
    list["rotation3"] = {
        plant_of({"x", "y", "z", "vx", "vy", "vz"},
                 {"vx", "vy", "vz", "-x * (x^2 + y^2 + z^2)", "-y * (x^2 + y^2 + z^2)", "-z * (x^2 + y^2 + z^2)"},
                 {"mx", "my", "mz"}, {"x", "y", "z"}),
        {.kind = "rotation3", .vectors = {{"x", "y", "z"}, {"vx", "vy", "vz"}, {"mx", "my", "mz"}}}};
    list["permutation"] = {
        plant_of({"p", "q", "r"}, {"q + r - 2 * p - p^3", "p + r - 2 * q - q^3", "p + q - 2 * r - r^3"},
                 {"sum", "a", "b", "c"}, {"p + q + r", "p", "q", "r"}),
        {.kind = "permutation", .vectors = {{"p", "q", "r"}, {"a", "b", "c"}}}};
    PlantConfig rotor = plant_of({"theta", "omega"}, {"omega", "sin(3 * theta) - 0.2 * omega"}, {"angle"}, {"theta"});
    rotor.state_wraps = {kTurn, 0.0};
    rotor.output_wraps = {kTurn};
    list["shift"] = {rotor, {.kind = "shift", .channels = {"theta", "angle"}, .fold = 3}};
    return list;
  }();
  return all;
}

class EverySymmetry : public ::testing::TestWithParam<SymmetryKind> {
 protected:
  EverySymmetry()
      : config(examples().at(std::string(GetParam().name)).symmetry),
        plant(make_plant(examples().at(std::string(GetParam().name)).plant)),
        symmetry(on_channels(config, plant->outputs(), plant->states())) {}

  Element drawn() {
    return symmetry.kind->draw(symmetry.components, symmetry.fold,
                               [&] { return static_cast<float>(uniform01(engine)); });
  }
  /// On the states.
  RowMap map_of(const Element& element) const { return image_of(symmetry, element, ny(), nx()).states; }
  int nx() const { return static_cast<int>(plant->nx()); }
  int ny() const { return static_cast<int>(plant->ny()); }
  MatrixXd points(Eigen::Index count) {
    return MatrixXd::NullaryExpr(plant->nx(), count, [&](auto, auto) { return 2.0 * uniform01(engine) - 1.0; });
  }

  std::mt19937_64 engine{1};
  SymmetryConfig config;
  std::unique_ptr<Plant> plant;
  Symmetry symmetry;
};

TEST_P(EverySymmetry, MovesSomethingAndKeepsLengths) {
  const MatrixXd x = points(3);
  bool moved = false;
  for (int i = 0; i < 20; ++i) {
    const RowMap map = map_of(drawn());
    moved = moved || !map.values(x).isApprox(x);
    for (Eigen::Index k = 0; k < x.cols(); ++k)
      EXPECT_NEAR(map.derivatives(x).col(k).norm(), x.col(k).norm(), kRounding);
  }
  EXPECT_TRUE(moved);
}

TEST_P(EverySymmetry, AnElementAndItsInverseAreTheIdentityInEitherOrder) {
  const MatrixXd x = points(3);
  for (int i = 0; i < 20; ++i) {
    const Element element = drawn();
    const Element inverse{element.matrix.transpose(), -element.turns};
    for (const auto& [first, second] : {std::pair{element, inverse}, {inverse, element}}) {
      RowMap map = map_of(first);
      map.then(symmetry.states, second);
      EXPECT_LT((map.values(x) - x).cwiseAbs().maxCoeff(), kRounding);
    }
  }
}

TEST_P(EverySymmetry, OneElementAfterAnotherIsTheirComposition) {
  const MatrixXd x = points(3);
  for (int i = 0; i < 20; ++i) {
    const Element first = drawn(), second = drawn();
    RowMap both = map_of(first);
    both.then(symmetry.states, second);
    EXPECT_LT((both.values(x) - map_of(second).values(map_of(first).values(x))).cwiseAbs().maxCoeff(), kRounding);
    EXPECT_LT((both.derivatives(x) - map_of(second).derivatives(map_of(first).derivatives(x))).cwiseAbs().maxCoeff(),
              kRounding);
  }
}

TEST_P(EverySymmetry, ThoseThatStandForAllHaveTheirMeanAndDeviations) {
  const VectorXd x = points(1);
  const auto moments = [&](const std::vector<RowMap>& maps) {
    MatrixXd sums = MatrixXd::Zero(x.size(), 2);
    for (const RowMap& map : maps) {
      const VectorXd image = map.derivatives(x);
      sums.col(0) += image;
      sums.col(1) += image.cwiseAbs2();
    }
    return MatrixXd(sums / static_cast<double>(maps.size()));
  };
  std::vector<RowMap> few = {RowMap(nx())}, many;
  for (const Image& image : other_images({symmetry}, ny(), nx())) few.push_back(image.states);
  constexpr int kDraws = 20000;
  for (int i = 0; i < kDraws; ++i) many.push_back(map_of(drawn()));
  // Five standard errors of a mean of numbers within the length of x.
  const double tolerance = 5.0 * std::max(x.norm(), x.squaredNorm()) / std::sqrt(kDraws);
  EXPECT_LT((moments(few) - moments(many)).cwiseAbs().maxCoeff(), tolerance);
}

TEST_P(EverySymmetry, TheImageOfARunIsTheRunFromTheImageOfItsStart) {
  SimulationConfig simulation;
  simulation.horizon_s = 4.0;
  simulation.sample_period_s = 0.02;
  simulation.initial_low.assign(plant->states().size(), -1.0);
  simulation.initial_high.assign(plant->states().size(), 1.0);
  ASSERT_EQ(symmetry_counterexample(*plant, config, simulation).value_or("none"), "none");
  const MatrixXd start = points(4);
  const Dataset runs = simulate_from(*plant, simulation, start);
  for (int i = 0; i < 5; ++i) {
    const Image image = image_of(symmetry, drawn(), ny(), nx());
    const Dataset others = simulate_from(*plant, simulation, image.states.values(start));
    for (std::size_t r = 0; r < runs.trajectories.size(); ++r) {
      constexpr double kRungeKutta = 1e-9;  // rounding that 200 steps carry on
      const Trajectory &run = runs.trajectories[r], &other = others.trajectories[r];
      EXPECT_LT((image.states.values(run.states) - other.states).cwiseAbs().maxCoeff(), kRungeKutta);
      EXPECT_LT((image.readings.values(run.outputs) - other.outputs).cwiseAbs().maxCoeff(), kRungeKutta);
    }
  }
}

TEST(SymmetryOfAnEncodedAngle, MovesSineAndCosineOnAndTurnsTheSignOfTheSineAlone) {
  const std::vector<codegen::Channel> channels = {{"b", "", 0.0}, {"a_sin", "", 0.0}, {"a_cos", "", 0.0}};
  const auto image = [&](const std::string& kind, float drawn) {
    const Symmetry symmetry = on_channels({.kind = kind, .channels = {"a", "b_is_not_here"}}, channels, {});
    const Element element = symmetry.kind->draw(symmetry.components, 0, [&] { return drawn; });
    return VectorXd(
        image_of(symmetry, element, 3, 0).readings.values(Eigen::Vector3d(0.2, std::sin(0.5), std::cos(0.5))));
  };
  constexpr double kFloat = 1e-6;  // of the number that was drawn
  for (const char* kind : {"shift", "rotation2"}) {
    const double moved = 0.5 + 2.0 * 3.14159265358979 * 0.3;
    EXPECT_LT((image(kind, 0.3F) - Eigen::Vector3d(0.2, std::sin(moved), std::cos(moved))).norm(), kFloat) << kind;
  }
  EXPECT_EQ(image("sign", 0.3F), Eigen::Vector3d(0.2, -std::sin(0.5), std::cos(0.5)));
}

INSTANTIATE_TEST_SUITE_P(Table, EverySymmetry, ::testing::ValuesIn(symmetry_kinds().begin(), symmetry_kinds().end()),
                         [](const auto& kind) { return std::string(kind.param.name); });

}  // namespace
}  // namespace nlo::trainer
