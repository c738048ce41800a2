// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "codegen/model/activations.h"
#include "trainer/gradients/nn/network_shape.h"

namespace nlo::trainer {
namespace {

TEST(NetworkShape, LaysParametersOutOneAfterTheOtherWithoutGaps) {
  const NetworkShape shape = NetworkShape::make({3, 5, 7, 2}, Activation::kTanh, true);
  ASSERT_EQ(shape.layers.size(), 3U);
  int offset = 0;
  for (const LayerView& layer : shape.layers) {
    EXPECT_EQ(layer.weights, offset);
    EXPECT_EQ(layer.bias, offset + layer.in * layer.out);
    offset = layer.bias + layer.out;
  }
  EXPECT_EQ(shape.linear_path, offset);
  EXPECT_EQ(shape.parameters, offset + 3 * 2);
  EXPECT_EQ(multiply_adds(shape), 3 * 5 + 5 * 7 + 7 * 2 + 3 * 2);
}

TEST(InitialParameters, AreThoseOfGlorotOrHeByActivationWithZeroBiases) {
  for (const std::string& name : codegen::activation_names()) {
    SCOPED_TRACE(name);
    const codegen::ActivationRow& activation = codegen::activation_named(name);
    const bool glorot = activation.weight_bound == codegen::WeightBound::kGlorot;
    EXPECT_EQ(glorot, name == "tanh");
    const NetworkShape shape = NetworkShape::make({30, 50, 20}, activation.kind, true);
    const std::vector<float> p = initial_parameters(shape, 5, 0.5F);
    ASSERT_EQ(p.size(), static_cast<std::size_t>(shape.parameters));
    double factor = 1.0;
    for (const LayerView& layer : shape.layers) {
      const double fans = glorot ? layer.in + layer.out : layer.in;
      const double bound = factor * std::sqrt(6.0 / fans);
      double reach = 0.0;
      double squares = 0.0;
      const int count = layer.in * layer.out;
      for (int i = 0; i < count; ++i) {
        const auto w = static_cast<double>(p[static_cast<std::size_t>(layer.weights + i)]);
        reach = std::max(reach, std::abs(w));
        squares += w * w;
      }
      // The largest of 1,000 uniform numbers is within 2 % of the bound; their variance is within 15 % of bound^2 / 3
      // (five standard errors).
      EXPECT_LE(reach, bound * (1.0 + 1e-6));
      EXPECT_GT(reach, bound * 0.98);
      EXPECT_NEAR(squares / count, bound * bound / 3.0, 0.15 * bound * bound / 3.0);
      for (int o = 0; o < layer.out; ++o) EXPECT_EQ(p[static_cast<std::size_t>(layer.bias + o)], 0.0F);
      factor = 0.5;  // the last layer is scaled
    }
    for (int i = shape.linear_path; i < shape.parameters; ++i) EXPECT_EQ(p[static_cast<std::size_t>(i)], 0.0F);
  }
}

TEST(InitialParameters, DependOnlyOnTheSeed) {
  const NetworkShape shape = NetworkShape::make({3, 20, 2}, Activation::kTanh, false);
  EXPECT_EQ(initial_parameters(shape, 5, 1.0F), initial_parameters(shape, 5, 1.0F));
  EXPECT_NE(initial_parameters(shape, 5, 1.0F), initial_parameters(shape, 6, 1.0F));
}

}  // namespace
}  // namespace nlo::trainer
