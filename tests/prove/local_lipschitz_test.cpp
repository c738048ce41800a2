// SPDX-License-Identifier: MIT
// The Lipschitz constant of T* over its domain: no slope that a search finds exceeds it, it never exceeds the global
// constant, and it equals known constants.
#include "trainer/prove/lipschitz.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "codegen/model/latent_step.h"
#include "codegen/reference/reference_network.h"
#include "codegen/replay/reference_observer.h"
#include "tests/prove/random_inverse_map.h"
#include "trainer/prove/activation_slope.h"
#include "trainer/prove/jacobian_enclosure.h"

namespace nlo::trainer {
namespace {

constexpr double kRounding = 1e-9;

double uniform(std::mt19937& engine, double low, double high) {
  return low + (high - low) * static_cast<double>(engine()) / 4294967296.0;
}

/// A random point of the box.
Eigen::VectorXd point_in(const InputBox& box, std::mt19937& engine) {
  return box.centre.array() +
         box.radius.array() * Eigen::ArrayXd::NullaryExpr(box.centre.size(), [&] { return uniform(engine, -1, 1); });
}

/// A model whose domain has this half width; outputs are within 1.
codegen::Model domain_model(unsigned seed, const std::string& activation, int hidden_layers, double half_width) {
  codegen::Model model = random_model(seed, activation, hidden_layers);
  std::mt19937 engine(seed + 77);
  const Eigen::VectorXd centre = random(engine, kNz, 1);
  model.latent_min = centre.array() - half_width;
  model.latent_max = centre.array() + half_width;
  model.output_min = -Eigen::VectorXd::Ones(kNy);
  model.output_max = Eigen::VectorXd::Ones(kNy);
  return model;
}

LocalLipschitzOptions boxes(std::int64_t most) {
  LocalLipschitzOptions options;
  options.boxes = most;
  return options;
}

class LocalLipschitzOf : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Activations, LocalLipschitzOf, testing::ValuesIn(codegen::activation_names()));

TEST_P(LocalLipschitzOf, SlopeLinesHoldOverTheirIntervals) {
  const codegen::ActivationRow& activation = codegen::activation_named(GetParam());
  std::mt19937 engine(3);
  for (int trial = 0; trial < 2000; ++trial) {
    const double width = std::pow(10.0, uniform(engine, -3, 1.2));
    Eigen::VectorXd low(1), high(1), v(1), lowest, highest;
    low << uniform(engine, -6, 6) - 0.5 * width;
    high << low(0) + width;
    v << uniform(engine, low(0), high(0));
    const SlopeRange range = slope_range(activation, low(0), high(0));
    const SlopeLine line = slope_line(activation, low, high, v);
    activated_range(activation, low, high, lowest, highest);
    const ActivationLine itself = activation_line(activation, low, high);
    for (int i = 0; i <= 40; ++i) {
      const double x = low(0) + width * i / 40.0, slope = activation.slope(x);
      ASSERT_GE(slope, range.low - kRounding);
      ASSERT_LE(slope, range.high + kRounding);
      ASSERT_LE(std::abs(slope - line.centre(0)), line.range(0) + kRounding);
      ASSERT_LE(std::abs(slope - line.centre(0) - line.gradient(0) * (x - v(0))), line.remainder(0) + kRounding)
          << "on [" << low(0) << ", " << high(0) << "] at " << x;
      ASSERT_LE(std::abs(activation.value(x) - itself.offset(0) - itself.gradient(0) * x),
                itself.remainder(0) + kRounding)
          << "on [" << low(0) << ", " << high(0) << "] at " << x;
      ASSERT_GE(activation.value(x), lowest(0) - kRounding);
      ASSERT_LE(activation.value(x), highest(0) + kRounding);
    }
  }
}

TEST_P(LocalLipschitzOf, NoJacobianOfABoxIsAboveItsBound) {
  for (unsigned seed = 1; seed <= 18; ++seed) {
    const codegen::Model model = random_model(seed, GetParam(), static_cast<int>(seed % 4));
    const Eigen::Index n = kNz + kNy;
    const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(n, n);
    const JacobianEnclosure enclosure(*codegen::inverse_map(model), identity, identity.leftCols(kNz));
    std::mt19937 engine(seed);
    for (const double radius : {1e-6, 0.01, 0.1, 0.5, 2.0}) {
      for (int trial = 0; trial < 4; ++trial) {
        const InputBox box{random(engine, n, 1), radius * random(engine, n, 1).cwiseAbs()};
        const double bound = enclosure.over(box).norm;
        for (int i = 0; i < 30; ++i) {
          const Eigen::VectorXd p = point_in(box, engine);
          const double slope = spectral_norm(inverse_map_jacobian(model, p.head(kNz), p.tail(kNy)).leftCols(kNz));
          ASSERT_NEAR(enclosure.at(p), slope, kRounding * (1.0 + slope));
          ASSERT_LE(slope, bound) << "seed " << seed << ", radius " << radius;
        }
      }
    }
  }
}

TEST_P(LocalLipschitzOf, NoOutputOfABoxIsOutsideItsRange) {
  int beside = 0;  // points beyond half of the range: the control
  for (unsigned seed = 1; seed <= 18; ++seed) {
    const codegen::Model model = random_model(seed, GetParam(), static_cast<int>(seed % 4));
    const codegen::ReferenceNetwork<double> map(*codegen::inverse_map(model));
    const Eigen::Index n = kNz + kNy;
    const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(n, n);
    const JacobianEnclosure enclosure(*codegen::inverse_map(model), identity, identity);
    std::mt19937 engine(seed);
    for (const double radius : {0.0, 1e-6, 0.01, 0.1, 0.5, 2.0}) {
      for (int trial = 0; trial < 4; ++trial) {
        const InputBox box{random(engine, n, 1), radius * random(engine, n, 1).cwiseAbs()};
        const JacobianEnclosure::Values values = enclosure.values_over(box);
        const Eigen::VectorXd middle = 0.5 * (values.low + values.high), reach = 0.5 * (values.high - values.low);
        for (int i = 0; i < 30; ++i) {
          const Eigen::VectorXd out = map(point_in(box, engine));
          const Eigen::VectorXd size = kRounding * (Eigen::VectorXd::Ones(out.size()) + out.cwiseAbs());
          ASSERT_TRUE(((out - middle).cwiseAbs().array() <= (reach + 1e-4 * size).array()).all())
              << "seed " << seed << ", radius " << radius << ": " << out.transpose() << " in " << middle.transpose()
              << " +- " << reach.transpose();
          beside += ((out - middle).cwiseAbs().array() > 0.5 * reach.array()).any();
        }
      }
    }
  }
  EXPECT_GT(beside, 100);
}

using Exact = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

/// d T* / d z in long double, for tanh.
Exact exact_jacobian(const codegen::Network& m, const Eigen::VectorXd& p) {
  const Exact scale = m.feature_scale.cast<long double>().cwiseInverse();
  const Exact features = scale.asDiagonal() * m.features.cast<long double>();
  Exact a = features * p.cast<long double>() - scale.cwiseProduct(m.feature_mean.cast<long double>());
  Exact jacobian = features.leftCols(kNz);
  const Exact path = m.skip.size() == 0 ? Exact(Exact::Zero(kNx, kNz)) : Exact(m.skip.cast<long double>() * jacobian);
  for (std::size_t l = 0; l < m.layers.size(); ++l) {
    a = (m.layers[l].weights.cast<long double>() * a + m.layers[l].bias.cast<long double>()).eval();
    jacobian = (m.layers[l].weights.cast<long double>() * jacobian).eval();
    if (l + 1 == m.layers.size()) break;
    a = a.unaryExpr([](long double v) { return std::tanh(v); }).eval();
    jacobian = (a.unaryExpr([](long double t) { return 1.0L - t * t; }).asDiagonal() * jacobian).eval();
  }
  return m.output_scale.cast<long double>().asDiagonal() * (jacobian + path);
}

/// Returns the largest |m v| / |v| over many unit vectors and a power iteration, a lower bound of the norm.
long double reached_norm(const Exact& m) {
  Exact v = Exact::Ones(m.cols(), 1);
  for (int i = 0; i < 2000; ++i) {
    v = (m.transpose() * (m * v)).eval();
    v /= v.norm();
  }
  return (m * v).norm() / v.norm();
}

TEST(JacobianEnclosure, BoundsTheExactValue) {
  constexpr long double kClose = 1e-9L;
  const Eigen::Index n = kNz + kNy;
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(n, n);
  int below = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    const codegen::Model model = random_model(seed, "tanh", static_cast<int>(seed % 4));
    const JacobianEnclosure enclosure(*codegen::inverse_map(model), identity, identity.leftCols(kNz));
    std::mt19937 engine(seed);
    const Eigen::VectorXd p = random(engine, n, 1);
    const double bound = enclosure.over({p, Eigen::VectorXd::Zero(n)}).norm;
    const double computed = spectral_norm(inverse_map_jacobian(model, p.head(kNz), p.tail(kNy)).leftCols(kNz));
    const long double exact = reached_norm(exact_jacobian(*codegen::inverse_map(model), p));
    EXPECT_GE(static_cast<long double>(bound), exact) << "seed " << seed;
    if (seed % 4 == 0) {  // one layer: the bound has no other part
      EXPECT_LE(static_cast<long double>(bound), exact * (1.0L + kClose));
    }
    below += static_cast<long double>(computed) < exact;
  }
  EXPECT_GT(below, 5) << "control: without the rounding term it is below";
}

TEST(JacobianEnclosure, IsSharpToSecondOrderForSmoothActivations) {
  // The bound exceeds the largest norm at many points of a box by an amount that falls with the square of the box size.
  const Eigen::Index n = kNz + kNy;
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(n, n);
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const codegen::Model model = random_model(seed, "tanh", 2);
    const JacobianEnclosure enclosure(*codegen::inverse_map(model), identity, identity.leftCols(kNz));
    std::mt19937 engine(seed);
    const Eigen::VectorXd centre = random(engine, n, 1);
    double excess[2] = {};
    for (const int fine : {0, 1}) {
      const InputBox box{centre, Eigen::VectorXd::Constant(n, fine == 1 ? 1e-3 : 1e-2)};
      double largest = 0.0;
      for (unsigned corner = 0; corner < 1u << n; ++corner) {
        Eigen::VectorXd p = box.centre;
        for (Eigen::Index k = 0; k < n; ++k) p(k) += (corner >> k & 1u) != 0 ? box.radius(k) : -box.radius(k);
        largest = std::max(largest, enclosure.at(p));
      }
      excess[fine] = enclosure.over(box).norm - largest;
    }
    EXPECT_GE(excess[1], 0.0);
    EXPECT_LT(excess[1], excess[0] / 50.0) << "a hundredth, with a margin for rounding and third order; seed " << seed;
  }
}

TEST_P(LocalLipschitzOf, IsBetweenTheLargestFoundSlopeAndTheGlobalBound) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const codegen::Model model = domain_model(seed, GetParam(), static_cast<int>(seed % 4), 0.8);
    for (const bool of_output : {false, true}) {
      const LipschitzConstants global = lipschitz_upper(model);
      const LocalLipschitz local = local_lipschitz(model, of_output, boxes(300));
      EXPECT_LE(local.bound, of_output ? global.output : global.latent);
      EXPECT_GE(local.bound * (1.0 + kRounding), local.found);
      EXPECT_LE(local.boxes, 300);
      const Eigen::MatrixXd there = inverse_map_jacobian(model, local.steepest.head(kNz), local.steepest.tail(kNy));
      EXPECT_NEAR(spectral_norm(of_output ? there.rightCols(kNy) : there.leftCols(kNz)), local.found,
                  kRounding * (1.0 + local.found))
          << "at the point that it names";
      std::mt19937 engine(seed);
      const InputBox box{0.5 * (model.latent_min + model.latent_max), 0.5 * (model.latent_max - model.latent_min)};
      for (int i = 0; i < 200; ++i) {
        const LipschitzConstants slope =
            lipschitz_sampled(model, point_in(box, engine), random(engine, kNy, 1).cwiseMax(-1.0).cwiseMin(1.0));
        ASSERT_LE(of_output ? slope.output : slope.latent, local.bound * (1.0 + kRounding)) << "seed " << seed;
      }
    }
  }
}

TEST(LocalLipschitz, IsTheSteepestSlopeIfTheSearchFinishes) {
  for (unsigned seed = 1; seed <= 9; seed += 2) {  // without y: three dimensions
    const codegen::Model model = domain_model(seed, "tanh", 2, 0.5);
    const LocalLipschitz local = local_lipschitz(model);
    EXPECT_LE(local.bound, 1.0101 * local.found) << "seed " << seed << ", " << local.boxes << " boxes";
    EXPECT_LT(local.bound, 0.9 * lipschitz_upper(model).latent) << "control: the global constant is larger";
  }
}

TEST(LocalLipschitz, NeverGrowsWithMoreExaminedBoxes) {
  const codegen::Model model = domain_model(5, "silu", 3, 1.0);
  double before = lipschitz_upper(model).latent;
  for (const std::int64_t most : {1, 10, 100, 1000}) {
    const double bound = local_lipschitz(model, false, boxes(most)).bound;
    EXPECT_LE(bound, before);
    before = bound;
  }
  EXPECT_LT(before, 0.8 * lipschitz_upper(model).latent);
}

TEST(LocalLipschitz, IsTheLargestSlopeInTheDomainForOneNeuron) {
  codegen::Model model = domain_model(1, "tanh", 0, 1.0);
  codegen::Network& net = *codegen::inverse_map(model);
  net = {};
  net.features = Eigen::MatrixXd::Identity(1, kNz + kNy);  // only z_0
  net.feature_mean = Eigen::VectorXd::Zero(1);
  net.feature_scale = Eigen::VectorXd::Ones(1);
  net.layers = {{Eigen::MatrixXd::Constant(1, 1, 3.0), Eigen::VectorXd::Zero(1)},
                {Eigen::Vector2d(0.0, 2.0), Eigen::Vector2d::Zero()}};
  net.output_mean = Eigen::Vector2d::Zero();
  net.output_scale = Eigen::Vector2d::Ones();
  model.latent_min(0) = 0.5;
  model.latent_max(0) = 1.5;
  const double slope = 6.0 * (1.0 - std::pow(std::tanh(1.5), 2));
  const LocalLipschitz local = local_lipschitz(model);
  EXPECT_NEAR(local.found, slope, 1e-6 * slope);
  EXPECT_LE(local.bound, 1.0101 * slope);
  EXPECT_GE(lipschitz_upper(model).latent, 6.0) << "rounding included";
  EXPECT_LE(lipschitz_upper(model).latent, 6.0 * (1.0 + kRounding));
}

TEST(LocalLipschitz, UsesTheLatentBoxRelativeToTheSteadyStateOfAngles) {
  codegen::Model model = domain_model(2, "tanh", 2, 0.5);  // reads y
  model.outputs[1].wrap = 6.28;
  codegen::linear_latent(model)->eigenvalues = Eigen::Vector3d(-0.5, -1.0, -2.0);
  codegen::linear_latent(model)->output_injection = Eigen::MatrixXd::Ones(kNz, kNy);
  model.output_min(1) = -3.0;
  model.output_max(1) = 3.0;
  const Eigen::MatrixXd gain = codegen::steady_gain(model);
  const LocalLipschitz in_z = local_lipschitz(model, false, boxes(2000)),
                       in_y = local_lipschitz(model, true, boxes(2000));
  std::mt19937 engine(4);
  LipschitzConstants sampled;
  for (int i = 0; i < 4000; ++i) {
    Eigen::VectorXd z(kNz), y(kNy);
    for (Eigen::Index r = 0; r < kNz; ++r) z(r) = uniform(engine, model.latent_min(r), model.latent_max(r));
    for (Eigen::Index j = 0; j < kNy; ++j) y(j) = uniform(engine, model.output_min(j), model.output_max(j));
    const LipschitzConstants slope = lipschitz_sampled(model, z + gain.col(1) * y(1), y);
    sampled = {std::max(sampled.latent, slope.latent), std::max(sampled.output, slope.output)};
  }
  EXPECT_LE(sampled.latent, in_z.bound);
  EXPECT_LE(sampled.output, in_y.bound);
  EXPECT_LE(sampled.latent, in_z.found * (1.0 + kRounding)) << "the search finds more than 4,000 draws";
  EXPECT_LE(in_z.bound, lipschitz_upper(model).latent);
}

TEST(SteepestSlope, TriesTheGivenPoints) {
  const codegen::Model model = domain_model(4, "tanh", 3, 1.0);  // reads y
  std::mt19937 engine(9);
  Eigen::MatrixXd points(kNz + kNy, 400);
  double steepest = 0.0;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    for (Eigen::Index r = 0; r < kNz; ++r) points(r, i) = uniform(engine, model.latent_min(r), model.latent_max(r));
    for (Eigen::Index j = 0; j < kNy; ++j) points(kNz + j, i) = uniform(engine, -1.0, 1.0);
    steepest = std::max(steepest, lipschitz_sampled(model, points.col(i).head(kNz), points.col(i).tail(kNy)).latent);
  }
  EXPECT_GE(steepest_slope(model, false, 1, points).found, steepest);
  points.topRows(kNz).array() += 10.0;  // outside of the box
  EXPECT_EQ(steepest_slope(model, false, 1, points).found, steepest_slope(model, false, 1).found);
}

TEST(SteepestSlope, IsAtLeastAsSteepAsManyRandomPoints) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const codegen::Model model = domain_model(seed, "tanh", 3, 1.0);
    const LocalLipschitz steepest = steepest_slope(model, false);
    std::mt19937 engine(seed);
    const InputBox box{0.5 * (model.latent_min + model.latent_max), 0.5 * (model.latent_max - model.latent_min)};
    double sampled = 0.0;
    for (int i = 0; i < 2000; ++i)
      sampled = std::max(
          sampled,
          lipschitz_sampled(model, point_in(box, engine), random(engine, kNy, 1).cwiseMax(-1.0).cwiseMin(1.0)).latent);
    EXPECT_GE(steepest.found, sampled) << "seed " << seed;
  }
}

}  // namespace
}  // namespace nlo::trainer
