// SPDX-License-Identifier: MIT
// Forward mode of a network, and reverse mode through it. The PDE residual and phi(z) u need both.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "codegen/model/activations.h"
#include "trainer/gradients/nn/network_block.h"

namespace nlo::trainer {
namespace {

using Block = NetworkBlock<double, 8>;
constexpr int kStride = Block::kStride;
constexpr int kSamples = 5;  // number of used columns; a block has 8

struct Problem {
  NetworkShape shape;
  std::vector<double> parameters, transposed, input, direction, output_pull, tangent_pull;

  Problem(Activation activation, bool linear_path) : shape(NetworkShape::make({3, 6, 5, 2}, activation, linear_path)) {
    std::mt19937 random(9);
    std::uniform_real_distribution<double> uniform(-0.9, 0.9);
    const auto draw = [&](std::size_t size) {
      std::vector<double> values(size);
      for (double& value : values) value = uniform(random);
      return values;
    };
    parameters = draw(static_cast<std::size_t>(shape.parameters));
    transposed.resize(parameters.size());
    transpose_weights(shape, parameters.data(), transposed.data());
    input = draw(3 * kStride);
    direction = draw(3 * kStride);
    output_pull = draw(2 * kStride);
    tangent_pull = draw(2 * kStride);
    for (int r = 0; r < 2; ++r) {
      for (int s = kSamples; s < kStride; ++s)
        output_pull[static_cast<std::size_t>(r * kStride + s)] =
            tangent_pull[static_cast<std::size_t>(r * kStride + s)] = 0.0;
    }
  }

  void forward(Block& block) const {
    std::copy(input.begin(), input.end(), block.input());
    std::copy(direction.begin(), direction.end(), block.input_tangent());
    block.forward(parameters.data());
    block.forward_tangents(parameters.data());
  }

  /// A random linear functional of outputs and tangents.
  double loss() const {
    Block block(shape, true);
    forward(block);
    double sum = 0.0;
    for (std::size_t i = 0; i < output_pull.size(); ++i)
      sum += output_pull[i] * block.output()[i] + tangent_pull[i] * block.output_tangent()[i];
    return sum;
  }
};

std::vector<std::pair<Activation, std::string>> activations() {
  std::vector<std::pair<Activation, std::string>> all;
  for (const std::string& name : codegen::activation_names())
    all.emplace_back(codegen::activation_named(name).kind, name);
  return all;
}

TEST(NetworkTangents, AreTheDerivativeAlongTheDirection) {
  constexpr double kStep = 1e-6, kTolerance = 1e-9;  // rounding 1e-16 / 1e-6, truncation 1e-12
  for (const auto& [activation, name] : activations()) {
    for (const bool path : {false, true}) {
      SCOPED_TRACE(name);
      const Problem problem(activation, path);
      Block block(problem.shape, true), up(problem.shape, true), down(problem.shape, true);
      problem.forward(block);
      Problem moved = problem;
      for (std::size_t i = 0; i < moved.input.size(); ++i) moved.input[i] += kStep * problem.direction[i];
      moved.forward(up);
      for (std::size_t i = 0; i < moved.input.size(); ++i) moved.input[i] -= 2.0 * kStep * problem.direction[i];
      moved.forward(down);
      for (std::size_t i = 0; i < 2 * kStride; ++i)
        ASSERT_NEAR(block.output_tangent()[i], (up.output()[i] - down.output()[i]) / (2.0 * kStep), kTolerance);
    }
  }
}

TEST(NetworkTangents, GradientOfOutputsAndTangentsAgreesWithDifferences) {
  constexpr double kStep = 1e-5, kTolerance = 1e-8;  // truncation: 1e-10 of the third derivative
  for (const auto& [activation, name] : activations()) {
    for (const bool path : {false, true}) {
      SCOPED_TRACE(name);
      Problem problem(activation, path);
      Block block(problem.shape, true);
      problem.forward(block);
      std::copy(problem.output_pull.begin(), problem.output_pull.end(), block.output_cotangent());
      std::copy(problem.tangent_pull.begin(), problem.tangent_pull.end(), block.output_tangent_cotangent());
      block.clear_gradient();
      block.backward_tangents(problem.parameters.data(), problem.transposed.data());
      std::vector<double> gradient(problem.parameters.size());
      block.gradient(gradient.data());
      const std::vector<double> input_pull(block.input_cotangent(), block.input_cotangent() + 3 * kStride);
      const std::vector<double> direction_pull(block.input_tangent_cotangent(),
                                               block.input_tangent_cotangent() + 3 * kStride);
      const auto check = [&](const char* what, std::vector<double>& values, const std::vector<double>& expected) {
        for (std::size_t i = 0; i < values.size(); ++i) {
          const double kept = values[i];
          values[i] = kept + kStep;
          const double up = problem.loss();
          values[i] = kept - kStep;
          const double down = problem.loss();
          values[i] = kept;
          ASSERT_NEAR(expected[i], (up - down) / (2.0 * kStep), kTolerance) << what << " " << i;
        }
      };
      check("parameter", problem.parameters, gradient);
      check("input", problem.input, input_pull);
      check("direction", problem.direction, direction_pull);
    }
  }
}

TEST(NetworkTangents, ReverseWithoutTangentCotangentsEqualsPlainBackpropagation) {
  for (const auto& [activation, name] : activations()) {
    SCOPED_TRACE(name);
    const Problem problem(activation, true);
    Block both(problem.shape, true), plain(problem.shape);
    problem.forward(both);
    std::copy(problem.input.begin(), problem.input.end(), plain.input());
    plain.forward(problem.parameters.data());
    std::fill_n(both.output_tangent_cotangent(), 2 * kStride, 0.0);
    for (Block* block : {&both, &plain}) {
      std::copy(problem.output_pull.begin(), problem.output_pull.end(), block->output_cotangent());
      block->clear_gradient();
    }
    both.backward_tangents(problem.parameters.data(), problem.transposed.data());
    plain.backward(problem.parameters.data(), problem.transposed.data());
    std::vector<double> a(problem.parameters.size()), b(a.size());
    both.gradient(a.data());
    plain.gradient(b.data());
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-14) << i;
  }
}

}  // namespace
}  // namespace nlo::trainer
