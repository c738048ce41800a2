// SPDX-License-Identifier: MIT
#include "codegen/fold/quantise.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "bench/random_quantised_model.h"
#include "codegen/base/error.h"
#include "codegen/fold/fold.h"
#include "codegen/model/activations.h"
#include "codegen/reference/reference_network.h"
#include "tests/codegen/example_models.h"
#include "tests/codegen/unpacked_layer.h"
#include "tests/support/thrown_message.h"

namespace nlo::codegen {
namespace {

using testing::HasSubstr;

template <Activation kKind, class Last>
void unpack(const QuantisedMlp<kKind, Last>& mlp, std::vector<QuantisedLayer>& layers) {
  layers.push_back(unpacked(mlp.layer));
}
template <Activation kKind, class First, class... Rest>
requires(sizeof...(Rest) > 0) void unpack(const QuantisedMlp<kKind, First, Rest...>& mlp,
                                          std::vector<QuantisedLayer>& layers) {
  layers.push_back(unpacked(mlp.layer));
  unpack(mlp.tail, layers);
}

/// Runs random inputs, some of them far outside of the domain, through the template of the runtime and through its
/// emulation.
template <Activation kKind, int kWidth, int kDepth>
void expect_same_bits() {
  using Mlp = decltype(bench::random_quantised_map<kKind, kWidth, kDepth>().mlp);
  QuantisedMap<Mlp, LinearPath<float, 3, 2>> map{};
  const auto random = bench::random_quantised_map<kKind, kWidth, kDepth>();
  map.mlp = random.mlp;
  QuantisedNetwork network{kKind,
                           Eigen::Vector3f(0.1F, -2.0F, 0.0F),
                           Eigen::Vector3f(6553.4F, 1e4F, 3e3F),
                           {},
                           Eigen::Vector2f(random.scale[0], 3.0F * random.scale[1]),
                           Eigen::MatrixXf(2, 3)};
  network.linear_path << 0.3F, -0.7F, 0.01F, 0.0F, 1.1F, -0.2F;
  unpack(map.mlp, network.layers);
  for (int i = 0; i < 3; ++i) {
    map.centre[i] = network.centre(i);
    map.gain[i] = network.gain(i);
    for (int o = 0; o < 2; ++o) map.linear_path.weights[o][i] = network.linear_path(o, i);
  }
  for (int o = 0; o < 2; ++o) map.scale[o] = network.scale(o);

  bench::RandomUniform uniform{5};
  for (int k = 0; k < 2000; ++k) {
    Eigen::Vector3f in;
    for (float& value : in) value = (k % 10 == 0 ? 1e4F : 8.0F) * uniform();
    if (k == 77) in(1) = std::numeric_limits<float>::quiet_NaN();
    float got[2];
    map.evaluate(in.data(), got);
    const Eigen::VectorXf emulated = evaluate(network, in);
    for (int o = 0; o < 2; ++o) ASSERT_TRUE(got[o] == emulated(o) || k == 77) << k << ": " << got[o];
  }
}

TEST(QuantisedEmulation, HasTheBitsOfTheRuntime) {
  expect_same_bits<Activation::kTanh, 16, 2>();
  expect_same_bits<Activation::kRelu, 16, 2>();
  expect_same_bits<Activation::kTanh, 7, 3>();
  expect_same_bits<Activation::kSilu, 16, 2>();
  expect_same_bits<Activation::kRelu, 50, 4>();
}

/// Recomputes the guarantee of kernels/int16.h from the quantised network.
void expect_no_overflow(const QuantisedNetwork& q) {
  for (const QuantisedLayer& layer : q.layers) {
    EXPECT_GE(layer.shift, 1);
    EXPECT_LE(layer.shift, 31);
    for (Eigen::Index o = 0; o < layer.bias.size(); ++o) {
      std::int64_t sum = std::abs(std::int64_t{layer.bias(o)});
      for (Eigen::Index i = 0; i < layer.weights.cols(); ++i) {
        EXPECT_NE(layer.weights(o, i), -32768);
        sum += std::int64_t{32767} * std::abs(std::int64_t{layer.weights(o, i)});
      }
      EXPECT_LT(sum, std::int64_t{1} << 31);
    }
  }
}

/// Returns the largest difference to the network in double over inputs in the box, relative to the largest output.
double relative_error(const FoldedNetwork& folded, const InputBox& box, const QuantisedNetwork& q) {
  std::uint64_t state = 9;
  double error = 0.0, largest = 0.0;
  for (int k = 0; k < 2000; ++k) {
    Eigen::VectorXd in(folded.inputs());
    for (Eigen::Index i = 0; i < in.size(); ++i) {
      state = state * 6364136223846793005U + 1442695040888963407U;
      in(i) = box.min(i) + (box.max(i) - box.min(i)) * static_cast<double>(state >> 11) * 0x1p-53;
    }
    const Eigen::VectorXd all = with_products(folded.products, in);
    Eigen::VectorXd a = all;
    for (std::size_t l = 0; l < folded.layers.size(); ++l) {
      a = (folded.layers[l].weights * a + folded.layers[l].bias).eval();
      if (l + 1 == folded.layers.size()) break;
      a = a.unaryExpr(activation_row(folded.activation).value).eval();
    }
    if (folded.linear_path.size() != 0) a += folded.linear_path * all;
    fall_back(folded.fallback, all, a);
    error = std::max(error, (evaluate(q, in.cast<float>()).cast<double>() - a).cwiseAbs().maxCoeff());
    largest = std::max(largest, a.cwiseAbs().maxCoeff());
  }
  return error / largest;
}

bool has_int16(const Model& m) {
  return structure_name(m) == "kkl";
}

// Weights have 16 bits. The largest possible sum leaves about 12 of them, and a map has at most four layers of 50
// neurons.
constexpr double kBound = 3e-3;

TEST(Quantise, CannotOverflowAndStaysWithinItsBound) {
  for (const Model& m : example_models()) {
    if (!has_int16(m)) continue;
    const FoldedModel folded = fold(m);
    const QuantisedNetwork q = quantise(m, folded).map;
    expect_no_overflow(q);
    const double error = relative_error(*folded.inverse_map(), input_box(m, folded), q);
    EXPECT_LT(error, kBound) << m.name;
  }
}

std::string error_of(const Model& m) {
  return thrown_message([&] { expect_no_overflow(quantise(m, fold(m)).map); });
}

TEST(Quantise, NamesTheSupportedModels) {
  EXPECT_THAT(error_of(driven_model()), HasSubstr("driven_kkl; export with --scalar float"));
  EXPECT_THAT(error_of(luenberger_model()), HasSubstr("structure kkl"));
  Model large = activation_model("silu");
  inverse_map(large)->largest_activations = {1.0, 17.0};
  EXPECT_THAT(error_of(large), HasSubstr("inverse_map.layers[1] reaches 18.7, but int16 supports silu only up to 16"));
}

TEST(Quantise, RefusesHugeWeightsAndNamesTheirLayer) {
  for (const double huge : {1e6, 1e30, 1e300}) {
    Model m = tiny_model();
    inverse_map(m)->layers[0].weights(2, 1) = huge;
    EXPECT_THAT(error_of(m), HasSubstr("inverse_map.layers[0]: neuron 2 has sums up to")) << huge;
  }
  Model m = tiny_model();
  inverse_map(m)->layers[1].weights(0, 1) = 1e300;
  EXPECT_THAT(error_of(m), HasSubstr("inverse_map.layers[1]: row 0"));
}

/// Error over the whole box, relative to the largest output.
double error_of_quantised(const Model& m) {
  const FoldedModel folded = fold(m);
  const QuantisedNetwork q = quantise(m, folded).map;
  expect_no_overflow(q);
  return relative_error(*folded.inverse_map(), input_box(m, folded), q);
}

TEST(Quantise, RowsAndLayersOfZerosAreExact) {
  for (const char* activation : {"tanh", "relu", "silu"}) {
    Model m = activation_model(activation);
    inverse_map(m)->layers[0].weights.row(3).setZero();
    inverse_map(m)->layers[1].bias(5) = 0.0;
    inverse_map(m)->layers[1].weights.row(5).setZero();
    EXPECT_LT(error_of_quantised(m), kBound) << activation;
    for (DenseLayer& layer : inverse_map(m)->layers) {
      layer.weights.setZero();
      layer.bias.setZero();
    }
    inverse_map(m)->output_mean = Eigen::Vector2d(0.5, -3.0);
    EXPECT_LT(error_of_quantised(m), 1e-6) << activation;  // rounding of float: only the means remain
  }
}

TEST(Quantise, BiasesFarLargerThanWeightsSaturateOrDominate) {
  Model m = activation_model("tanh");
  inverse_map(m)->layers[0].bias(1) = 1e9;  // always 1
  inverse_map(m)->layers[1].bias(2) = -1e300;
  EXPECT_LT(error_of_quantised(m), kBound);
  m = activation_model("relu");
  inverse_map(m)->layers[0].bias.setConstant(100.0);
  inverse_map(m)->layers[2].bias.setConstant(1e6);
  EXPECT_LT(error_of_quantised(m), kBound);
}

TEST(Quantise, NarrowAndWideInputRangesKeepTheErrorBound) {
  Model m = tiny_model();
  m.latent_min(0) = 1.0;
  m.latent_max(0) = std::nextafter(1.0, 2.0);
  m.latent_min(1) = -1e-300;
  m.latent_max(1) = 1e-300;
  EXPECT_LT(error_of_quantised(m), kBound);
  m.latent_min(0) = -1e300;
  m.latent_max(0) = 1e300;
  EXPECT_THAT(error_of(m), HasSubstr("input 0 of inverse_map is beyond float"));
}

TEST(Quantise, AnyWeightsAreRefusedOrGiveSumsWithoutOverflow) {
  // Weights and biases over many decades, inputs at all corners of the box: the sanitizers detect an overflow.
  bench::RandomUniform random{3};
  const auto decades = [&random](float most) { return std::pow(10.0, static_cast<double>(most * random())); };
  int refused = 0, made = 0;
  for (int trial = 0; trial < 300; ++trial) {
    Model m = activation_model(trial % 2 == 0 ? "tanh" : "relu");
    for (DenseLayer& layer : inverse_map(m)->layers) {
      const double weight = decades(4.0F), bias = decades(6.0F);
      for (Eigen::Index o = 0; o < layer.bias.size(); ++o) {
        layer.weights.row(o) *= random() < -0.8F ? 0.0 : weight * decades(1.0F);
        layer.bias(o) *= bias;
      }
    }
    const FoldedModel folded = fold(m);
    try {
      const QuantisedNetwork q = quantise(m, folded).map;
      expect_no_overflow(q);
      for (int corner = 0; corner < 4; ++corner)
        EXPECT_TRUE(
            evaluate(q, Eigen::Vector2f(corner % 2 == 0 ? -1e30F : 1e30F, corner < 2 ? -1e30F : 1e30F)).allFinite());
      ++made;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("inverse_map.layers["));
      ++refused;
    }
  }
  EXPECT_GT(made, 100);
  EXPECT_GT(refused, 5);
}

/// Mean of (quantised - exact) over the box, which would be shifted if rounding were always downwards.
TEST(Quantise, CompensatesRoundingDown) {
  Model m = activation_model("tanh");
  // Positive weights, so that shifts add up.
  inverse_map(m)->layers.back().weights = inverse_map(m)->layers.back().weights.cwiseAbs().eval();
  const FoldedModel folded = fold(m);
  QuantisedNetwork q = quantise(m, folded).map;
  const auto mean_error = [&](const QuantisedNetwork& network) {
    const ReferenceNetwork<double> exact(*inverse_map(m));
    double sum = 0.0;
    constexpr int kInputs = 4000;
    for (int k = 0; k < kInputs; ++k) {
      const double phase = 0.01 * k;
      const Eigen::Vector3d in(2.0 * std::sin(phase), 0.4 * std::cos(1.7 * phase), 0.0);
      sum += (static_cast<double>(evaluate(network, in.head(2).cast<float>())(0)) - exact(in)(0)) / kInputs;
    }
    return std::abs(sum);
  };
  const double made_up_for = mean_error(q);
  // Control: the network without the half unit in the biases of the last layer.
  for (Eigen::Index o = 0; o < q.outputs(); ++o)
    q.layers.back().bias(o) -= q.layers.back().weights.row(o).cast<int>().sum() / 2;
  EXPECT_LT(made_up_for, 0.7 * mean_error(q));
}

TEST(Quantise, ReluUsesTheRangesRecordedInTraining) {
  Model m = activation_model("relu");
  const FoldedModel folded = fold(m);
  const InputBox box = input_box(m, folded);
  const std::vector<double> guessed = largest_activations(*inverse_map(m), *folded.inverse_map(), box);
  inverse_map(m)->largest_activations = {guessed[0] / 2.2, guessed[1] / 2.2};
  const std::vector<double> recorded = largest_activations(*inverse_map(m), *folded.inverse_map(), box);
  for (std::size_t l = 0; l < 2; ++l) EXPECT_NEAR(recorded[l], guessed[l] / 2.0, 1e-12 * guessed[l]);
  // Half the range gives half the unit: the same integers represent values half as large.
  EXPECT_EQ(quantise(m, folded).map.layers[0].shift,
            quantise(activation_model("relu"), folded).map.layers[0].shift - 1);
}

}  // namespace
}  // namespace nlo::codegen
