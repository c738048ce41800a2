// SPDX-License-Identifier: MIT
#include "trainer/gradients/nn/network_block.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "tests/nn/plain_network.h"

namespace nlo::trainer {
namespace {

using testing::Doubles;
using testing::plain_pass;

// Tolerance of a forward result: float32 sums of up to 65 products of numbers about 1 (6e-8 each, accumulating like a
// random walk) through up to five layers, plus kTanhMaxError per unit; below 4e-6 measured.
constexpr double kForwardTolerance = 1e-5;
// Tolerance of an input cotangent, relative: it passes the same layers backwards; 1.1e-5 measured with slopes above 1.
constexpr double kCotangentTolerance = 2e-5;
// Tolerance relative to the largest entry of a gradient: rounding summed over 256 samples; below 4e-6 measured.
constexpr double kGradientTolerance = 1e-5;
// Step of central differences in double, relative to the largest entry: truncation kStep^2, rounding 1e-16 / kStep.
constexpr double kStep = 1e-5;
constexpr double kDifferenceTolerance = 1e-7;

struct Case {
  std::string name;
  std::vector<int> widths;
  Activation activation;
  bool linear_path;
};

std::vector<Case> cases() {
  const std::pair<const char*, std::vector<int>> shapes[] = {
      {"linear_3_2", {3, 2}},           {"linear_1_1", {1, 1}},
      {"hidden_1", {2, 1, 1}},          {"hidden_2_5", {3, 2, 5, 2}},
      {"hidden_5_7", {4, 5, 7, 3}},     {"hidden_7_65", {7, 7, 65, 5}},
      {"hidden_65_50", {6, 65, 50, 2}}, {"hidden_50x4", {3, 50, 50, 50, 50, 2}}};
  std::vector<Case> all;
  for (const auto& [shape_name, widths] : shapes) {
    for (const std::string& activation : codegen::activation_names()) {
      for (const bool path : {false, true})
        all.push_back({std::string(shape_name) + '_' + activation + (path ? "_with_path" : ""), widths,
                       codegen::activation_named(activation).kind, path});
    }
  }
  return all;
}

/// A network and a full block of inputs and output cotangents, drawn with a magnitude of about 1.
struct Problem {
  NetworkShape shape;
  std::vector<float> parameters, transposed, inputs, cotangents;

  explicit Problem(const Case& c, unsigned seed = 7)
      : shape(NetworkShape::make(c.widths, c.activation, c.linear_path)) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform(-1.0F, 1.0F);
    parameters = initial_parameters(shape, 3, 1.0F);
    for (float& p : parameters) p = p == 0.0F ? 0.3F * uniform(random) : p;  // also biases and the linear path
    transposed.resize(parameters.size());
    transpose_weights(shape, parameters.data(), transposed.data());
    const auto fill = [&](std::vector<float>& rows, int count, float reach) {
      rows.resize(static_cast<std::size_t>(count) * kRow);
      for (float& value : rows) value = reach * uniform(random);
    };
    fill(inputs, shape.inputs(), 1.5F);
    fill(cotangents, shape.outputs(), 1.0F);
  }

  Doubles column(const std::vector<float>& rows, int count, int sample) const {
    Doubles out;
    for (int i = 0; i < count; ++i) {
      out.push_back(static_cast<double>(rows[static_cast<std::size_t>(i * kRow + sample)]));
    }
    return out;
  }
  Doubles input(int sample) const { return column(inputs, shape.inputs(), sample); }
  Doubles cotangent(int sample) const { return column(cotangents, shape.outputs(), sample); }
  Doubles parameters_in_double() const { return {parameters.begin(), parameters.end()}; }

  /// Runs forward and backward over the first `samples` columns; the other columns keep their inputs and have zero
  /// cotangents.
  void run(WideBlock& workspace, int samples = kBlock) const {
    std::copy(inputs.begin(), inputs.end(), workspace.input());
    workspace.forward(parameters.data());
    for (int o = 0; o < shape.outputs(); ++o) {
      for (int s = 0; s < kBlock; ++s) {
        workspace.output_cotangent()[o * kRow + s] =
            s < samples ? cotangents[static_cast<std::size_t>(o * kRow + s)] : 0.0F;
      }
    }
    workspace.backward(parameters.data(), transposed.data());
  }
  std::vector<float> gradient(const WideBlock& workspace) const {
    std::vector<float> out(parameters.size());
    workspace.gradient(out.data());
    return out;
  }
  Doubles plain_gradient(int samples = kBlock) const {
    Doubles out(parameters.size(), 0.0);
    const Doubles p = parameters_in_double();
    for (int s = 0; s < samples; ++s) plain_pass(shape, p, input(s), cotangent(s), &out);
    return out;
  }
  double plain_loss(const Doubles& p, int samples) const {
    double loss = 0.0;
    for (int s = 0; s < samples; ++s) {
      const Doubles n = plain_pass(shape, p, input(s)).output;
      const Doubles g = cotangent(s);
      for (std::size_t o = 0; o < n.size(); ++o) loss += g[o] * n[o];
    }
    return loss;
  }
};

double largest(const Doubles& values) {
  double result = 0.0;
  for (const double v : values) result = std::max(result, std::abs(v));
  return result;
}

void expect_near(const std::vector<float>& actual, const Doubles& expected, double tolerance) {
  ASSERT_EQ(actual.size(), expected.size());
  const double allowed = tolerance * largest(expected);
  for (std::size_t i = 0; i < actual.size(); ++i) {
    ASSERT_NEAR(static_cast<double>(actual[i]), expected[i], allowed) << "parameter " << i << " of " << actual.size();
  }
}

/// Calls check(case) for each shape, activation and kind of path; stops at the first failure.
template <class Check>
void for_all_cases(const Check& check) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    check(c);
    if (::testing::Test::HasFatalFailure()) return;
  }
}

TEST(Network, ForwardAgreesWithThePlainNetwork) {
  for_all_cases([](const Case& c) {
    const Problem problem(c);
    WideBlock workspace(problem.shape);
    std::copy(problem.inputs.begin(), problem.inputs.end(), workspace.input());
    workspace.forward(problem.parameters.data());
    const Doubles p = problem.parameters_in_double();
    for (int s = 0; s < kBlock; ++s) {
      const Doubles expected = plain_pass(problem.shape, p, problem.input(s)).output;
      for (int o = 0; o < problem.shape.outputs(); ++o) {
        ASSERT_NEAR(static_cast<double>(workspace.output()[o * kRow + s]), expected[static_cast<std::size_t>(o)],
                    kForwardTolerance)
            << "sample " << s;
      }
    }
  });
}

TEST(Network, GradientAgreesWithPlainBackpropagation) {
  for_all_cases([](const Case& c) {
    const Problem problem(c);
    WideBlock workspace(problem.shape);
    problem.run(workspace);
    expect_near(problem.gradient(workspace), problem.plain_gradient(), kGradientTolerance);
  });
}

TEST(Network, InputCotangentAgreesWithPlainBackpropagation) {
  for_all_cases([](const Case& c) {
    const Problem problem(c);
    WideBlock workspace(problem.shape);
    problem.run(workspace);
    const Doubles p = problem.parameters_in_double();
    Doubles unused(p.size());
    for (int s = 0; s < kBlock; ++s) {
      const Doubles expected =
          plain_pass(problem.shape, p, problem.input(s), problem.cotangent(s), &unused).input_cotangent;
      for (int i = 0; i < problem.shape.inputs(); ++i) {
        ASSERT_NEAR(static_cast<double>(workspace.input_cotangent()[i * kRow + s]),
                    expected[static_cast<std::size_t>(i)], kCotangentTolerance * std::max(1.0, largest(expected)))
            << "sample " << s << " input " << i;
      }
    }
  });
}

TEST(Network, GradientAgreesWithCentralDifferences) {
  for_all_cases([](const Case& c) {
    constexpr int kSamples = 8;  // the rest of the block is unused
    constexpr std::size_t kProbes = 60;
    const Problem problem(c);
    WideBlock workspace(problem.shape);
    problem.run(workspace, kSamples);
    const std::vector<float> gradient = problem.gradient(workspace);
    const Doubles plain = problem.plain_gradient(kSamples);
    const double scale = largest(plain);
    const std::size_t stride = std::max<std::size_t>(1, plain.size() / kProbes);
    for (std::size_t i = 0; i < plain.size(); i += i + stride < plain.size() ? stride : 1) {
      Doubles p = problem.parameters_in_double();
      const double at = p[i];
      p[i] = at + kStep;
      const double above = problem.plain_loss(p, kSamples);
      p[i] = at - kStep;
      const double below = problem.plain_loss(p, kSamples);
      const double difference = (above - below) / (2.0 * kStep);
      ASSERT_NEAR(plain[i], difference, kDifferenceTolerance * scale) << "the reference itself, parameter " << i;
      ASSERT_NEAR(static_cast<double>(gradient[i]), difference, kGradientTolerance * scale) << "parameter " << i;
    }
  });
}

TEST(Network, SamplesWithoutCotangentDoNotContribute) {
  for_all_cases([](const Case& c) {
    for (const int samples : {0, 1, 100, 255}) {
      Problem problem(c);
      WideBlock workspace(problem.shape);
      problem.run(workspace, samples);
      const std::vector<float> gradient = problem.gradient(workspace);
      for (int i = 0; i < problem.shape.inputs(); ++i) {
        for (int s = samples; s < kBlock; ++s) problem.inputs[static_cast<std::size_t>(i * kRow + s)] = 3.7F;
      }
      WideBlock other(problem.shape);
      problem.run(other, samples);
      ASSERT_EQ(problem.gradient(other), gradient) << samples << " samples";
      WideBlock control(problem.shape);
      problem.run(control, samples + 1);
      ASSERT_NE(problem.gradient(control), gradient) << "control: one sample more does contribute";
    }
  });
}

TEST(Network, GradientAddsUpOverBlocksUntilItIsCleared) {
  for_all_cases([](const Case& c) {
    const Problem first(c, 1);
    const Problem second(c, 2);
    WideBlock workspace(first.shape);
    first.run(workspace);
    Problem same_weights = first;
    same_weights.inputs = second.inputs;
    same_weights.cotangents = second.cotangents;
    same_weights.run(workspace, 100);
    Doubles expected = first.plain_gradient();
    const Doubles more = same_weights.plain_gradient(100);
    for (std::size_t i = 0; i < expected.size(); ++i) expected[i] += more[i];
    expect_near(first.gradient(workspace), expected, kGradientTolerance);
    workspace.clear_gradient();
    for (const float g : first.gradient(workspace)) ASSERT_EQ(g, 0.0F);
  });
}

}  // namespace
}  // namespace nlo::trainer
