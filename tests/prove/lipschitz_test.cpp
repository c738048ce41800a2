// SPDX-License-Identifier: MIT
// Lipschitz constants of T*: the proven constant is never below a slope, and exact for maps with a known constant.
#include "trainer/prove/lipschitz.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "codegen/model/activations.h"
#include "codegen/reference/reference_network.h"
#include "tests/prove/random_inverse_map.h"

namespace nlo::trainer {
namespace {

class EachActivation : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Activations, EachActivation, testing::ValuesIn(codegen::activation_names()));

TEST_P(EachActivation, UpperBoundIsAboveEverySampledSlope) {
  for (unsigned seed = 1; seed <= 24; ++seed) {
    const codegen::Model model = random_model(seed, GetParam(), static_cast<int>(seed % 4));
    std::mt19937 engine(seed + 1000);
    const LipschitzConstants upper = lipschitz_upper(model);
    const LipschitzConstants lower =
        lipschitz_sampled(model, random(engine, kNz, 400, 2.0), random(engine, kNy, 400, 2.0));
    EXPECT_GE(upper.latent, lower.latent * (1.0 - 1e-12)) << "seed " << seed;
    EXPECT_GE(upper.output, lower.output * (1.0 - 1e-12)) << "seed " << seed;
    EXPECT_EQ(upper.output > 0.0, seed % 2 == 0) << "seed " << seed;
    EXPECT_GT(lower.latent, 0.0);
  }
}

TEST_P(EachActivation, UpperBoundIsBelowTheProductOfTheNorms) {
  double steepest = 0.0;
  for (const codegen::TurningPoint& turn : codegen::activation_named(GetParam()).slope_turns)
    steepest = std::max(steepest, turn.value);
  for (unsigned seed = 1; seed <= 24; seed += 4) {  // without a linear path
    const codegen::Model model = random_model(seed == 9 || seed == 21 ? seed + 4 : seed, GetParam(), 3);
    const codegen::Network& n = *codegen::inverse_map(model);
    double product =
        std::pow(steepest, 3) * spectral_norm(n.output_scale.asDiagonal() * n.layers[3].weights) *
        spectral_norm(n.layers[0].weights * n.feature_scale.cwiseInverse().asDiagonal() * n.features.leftCols(kNz));
    for (const std::size_t l : {std::size_t{1}, std::size_t{2}}) product *= spectral_norm(n.layers[l].weights);
    EXPECT_LT(lipschitz_upper(model).latent, product);
  }
}

TEST_P(EachActivation, JacobianAgreesWithFiniteDifferences) {
  constexpr double kStep = 1e-6, kTolerance = 1e-7;
  const codegen::Model model = random_model(6, GetParam(), 2);  // reads y, has a linear path
  std::mt19937 engine(7);
  const Eigen::VectorXd z = random(engine, kNz, 1), y = random(engine, kNy, 1);
  Eigen::VectorXd input(kNz + kNy);
  input << z, y;
  const codegen::ReferenceNetwork<double> map(*codegen::inverse_map(model));
  const Eigen::MatrixXd jacobian = inverse_map_jacobian(model, z, y);
  for (Eigen::Index i = 0; i < input.size(); ++i) {
    Eigen::VectorXd above = input, below = input;
    above(i) += kStep;
    below(i) -= kStep;
    const Eigen::VectorXd slope = (map(above) - map(below)) / (2.0 * kStep);
    EXPECT_LT((jacobian.col(i) - slope).norm(), kTolerance * (1.0 + slope.norm()));
  }
}

TEST(Lipschitz, IsExactForALinearMap) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const codegen::Model model = random_model(seed, "tanh", 0);
    const Eigen::MatrixXd origin = Eigen::MatrixXd::Zero(kNz, 1), y = Eigen::MatrixXd::Zero(kNy, 1);
    const LipschitzConstants upper = lipschitz_upper(model), lower = lipschitz_sampled(model, origin, y);
    EXPECT_NEAR(upper.latent, lower.latent, 1e-12 * upper.latent);
    EXPECT_NEAR(upper.output, lower.output, 1e-12 * upper.latent);
  }
}

TEST(Lipschitz, IsReachedByAReluNetworkOfIdentities) {
  codegen::Network network;
  network.features = Eigen::MatrixXd::Identity(2, kNz + kNy);
  network.feature_mean = Eigen::Vector2d::Zero();
  network.feature_scale = network.output_scale = Eigen::Vector2d::Ones();
  network.output_mean = Eigen::Vector2d::Zero();
  network.activation = Activation::kRelu;
  for (int l = 0; l < 4; ++l) network.layers.push_back({Eigen::Matrix2d::Identity(), Eigen::Vector2d::Zero()});
  const codegen::Model model = model_with(network);
  EXPECT_NEAR(lipschitz_upper(model).latent, 1.0, 1e-12);
  EXPECT_NEAR(lipschitz_sampled(model, Eigen::MatrixXd::Ones(kNz, 1), Eigen::MatrixXd::Zero(kNy, 1)).latent, 1.0,
              1e-12);
}

}  // namespace
}  // namespace nlo::trainer
