// SPDX-License-Identifier: MIT
// Learned maps and their forward-mode products, compared with the same network and its derivative in double: values
// within an error bound that is propagated through the layers; products also compared with finite differences.
#include <nlo/jvp.h>
#include <nlo/mlp.h>
#include <nlo/mlp_batch.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "tests/runtime/testing.h"

namespace nlo {
namespace {

template <class Scalar, int kIn, int kOut>
Dense<Scalar, kIn, kOut> random_dense(std::mt19937& random) {
  const auto draw = [&random] {  // never near zero, so that each weight has an effect
    const Scalar size = testing::uniform<Scalar>(random, 0.2, 1.0);
    return (random() & 1U) != 0 ? size : -size;
  };
  Dense<Scalar, kIn, kOut> layer{};
  for (auto& row : layer.weights) {
    for (Scalar& weight : row) weight = draw() / std::sqrt(static_cast<Scalar>(kIn));
  }
  for (Scalar& bias : layer.bias) bias = draw();
  return layer;
}

/// Values, bounds of their errors, and their tangents.
struct Signal {
  std::vector<double> value, error, tangent;
};

template <class Scalar, int kIn, int kOut>
Signal affine(const Dense<Scalar, kIn, kOut>& layer, const Signal& in) {
  constexpr double kEps = static_cast<double>(std::numeric_limits<Scalar>::epsilon());
  Signal out;
  for (int o = 0; o < kOut; ++o) {
    double sum = static_cast<double>(layer.bias[o]), magnitude = std::fabs(sum), error = 0.0, slope = 0.0;
    for (int i = 0; i < kIn; ++i) {
      const auto from = static_cast<std::size_t>(i);
      const double weight = static_cast<double>(layer.weights[o][i]);
      sum += weight * in.value[from];
      magnitude += std::fabs(weight * in.value[from]);
      error += std::fabs(weight) * in.error[from];
      slope += weight * in.tangent[from];
    }
    out.value.push_back(sum);
    out.error.push_back(error + (kIn + 2) * kEps * (magnitude + error));
    out.tangent.push_back(slope);
  }
  return out;
}

/// Slopes are at most 1 (tanh, relu) or 1.1 (silu); the error of silu grows with |v|.
template <Activation kKind>
Signal activated(Signal s) {
  for (std::size_t i = 0; i < s.value.size(); ++i) {
    const double v = s.value[i], sigmoid = 1.0 / (1.0 + std::exp(-v)), tanh = std::tanh(v);
    if (kKind == Activation::kTanh) {
      s.value[i] = tanh;
      s.error[i] += kTanhMaxError;
      s.tangent[i] *= 1.0 - tanh * tanh;
    }
    if (kKind == Activation::kRelu) {
      s.value[i] = std::fmax(v, 0.0);
      s.tangent[i] *= v > 0.0 ? 1.0 : 0.0;
    }
    if (kKind == Activation::kSilu) {
      s.value[i] = v * sigmoid;
      s.error[i] = 1.1 * s.error[i] + (1.0 + std::fabs(v)) * kTanhMaxError;
      s.tangent[i] *= sigmoid * (1.0 + v * (1.0 - sigmoid));
    }
  }
  return s;
}

template <Activation kKind, class Last>
Signal reference(const Signal& in, const Last& last) {
  return affine(last, in);
}
template <Activation kKind, class First, class... Rest>
Signal reference(const Signal& in, const First& first, const Rest&... rest) requires(sizeof...(Rest) > 0) {
  return reference<kKind>(activated<kKind>(affine(first, in)), rest...);
}

// Tangents are of order one. Each of two activation layers adds an error of the rational tanh (5e-7, and twice that in
// the slope) and about 50 roundings of float; in double only 4e-8 of the rational function.
template <class Scalar>
constexpr double kSlopeTolerance = sizeof(Scalar) == 4 ? 2e-5 : 1e-6;

/// Largest |computed - reference| / allowed over random inputs and directions; below 1 if they agree.
struct Disagreement {
  double value = 0.0, tangent = 0.0;
  bool none() const { return value < 1.0 && tangent < 1.0; }
};

template <Activation kKind, class... Layers>
Disagreement disagreement_of(const auto& network, const Layers&... layers) {
  using Network = std::decay_t<decltype(network)>;
  using Scalar = typename Network::Scalar;
  std::mt19937 random(77);
  Disagreement worst;
  for (int k = 0; k < 30; ++k) {
    Scalar in[Network::kIn], direction[Network::kIn], out[Network::kOut], slope[Network::kOut];
    Signal signal;
    for (int i = 0; i < Network::kIn; ++i) {
      in[i] = testing::uniform<Scalar>(random, -1.5, 1.5);
      direction[i] = testing::uniform<Scalar>(random, -1.0, 1.0);
      signal.value.push_back(static_cast<double>(in[i]));
      signal.error.push_back(0.0);
      signal.tangent.push_back(static_cast<double>(direction[i]));
    }
    network.evaluate(in, out);
    jvp(network, in, direction, slope);
    const Signal expected = reference<kKind>(signal, layers...);
    for (std::size_t o = 0; o < Network::kOut; ++o) {
      const double off = std::fabs(static_cast<double>(out[o]) - expected.value[o]);
      const double slope_off = std::fabs(static_cast<double>(slope[o]) - expected.tangent[o]);
      worst.value = std::fmax(worst.value, off / expected.error[o]);
      worst.tangent = std::fmax(worst.tangent, slope_off / kSlopeTolerance<Scalar>);
    }
  }
  return worst;
}

/// Expects a network of these layers to equal the layers themselves.
template <Activation kKind, class... Layers>
void expect_parity(const Layers&... layers) {
  EXPECT_TRUE((disagreement_of<kKind>(make_mlp<kKind>(layers...), layers...).none()));
}

template <class Scalar, Activation kKind>
void expect_parities() {
  std::mt19937 random(3);
  const auto a = random_dense<Scalar, 3, 50>(random);
  const auto b = random_dense<Scalar, 50, 17>(random);
  const auto c = random_dense<Scalar, 17, 5>(random);
  const auto d = random_dense<Scalar, 5, 8>(random);
  const auto e = random_dense<Scalar, 8, 2>(random);
  expect_parity<kKind>(a, b, c, d, e);
  expect_parity<kKind>(d, e);
  expect_parity<kKind>(c);  // one layer: linear
  expect_parity<kKind>(a);
}

TEST(Mlp, AgreesWithTheSameNetworkAndItsDerivativeInDouble) {
  expect_parities<float, Activation::kTanh>();
  expect_parities<float, Activation::kRelu>();
  expect_parities<float, Activation::kSilu>();
  expect_parities<double, Activation::kTanh>();
  expect_parities<double, Activation::kRelu>();
  expect_parities<double, Activation::kSilu>();
}

TEST(Mlp, ComparisonDetectsAnyWrongWeight) {  // control of the test above
  constexpr auto kKind = Activation::kTanh;
  std::mt19937 random(4);
  const auto first = random_dense<float, 3, 9>(random);
  const auto last = random_dense<float, 9, 2>(random);
  expect_parity<kKind>(first, last);
  auto wrong_first = first;
  auto wrong_last = last;
  const auto with = [&](float& weight, float factor) {
    const float good = weight;
    weight *= factor;
    const Disagreement worst = disagreement_of<kKind>(make_mlp<kKind>(wrong_first, wrong_last), first, last);
    weight = good;
    return worst;
  };
  const auto expect_noticed = [&](auto& layer, bool biases_bend) {
    for (auto& row : layer.weights) {
      for (float& weight : row) {
        EXPECT_GT(with(weight, -1.0F).value, 1.0);
        EXPECT_GT(with(weight, 1.01F).tangent, 1.0);
      }
    }
    for (float& bias : layer.bias) {
      EXPECT_GT(with(bias, -1.0F).value, 1.0);
      if (biases_bend) {
        EXPECT_GT(with(bias, 1.01F).tangent, 1.0);
      }
    }
  };
  expect_noticed(wrong_first, true);
  expect_noticed(wrong_last, false);  // a bias has no effect on the slope
}

TEST(InverseMap, AddsItsLinearPath) {
  std::mt19937 random(6);
  const auto first = random_dense<float, 5, 16>(random);
  const auto last = random_dense<float, 16, 3>(random);
  const auto network = make_mlp<Activation::kTanh>(first, last);
  using Path = LinearPath<float, 5, 3>;
  const LearnedMap<decltype(network), Path> with{network, Path{{{1, 2, 3, 4, 5}, {0, 0, 0, 0, 0}, {-1, 0, 0, 0, 8}}}};
  const LearnedMap<decltype(network)> without{network, {}};
  const float in[5] = {0.5F, -0.25F, 1.0F, 2.0F, -1.0F};
  float full[3], plain[3];
  with.evaluate(in, full);
  without.evaluate(in, plain);
  constexpr float kRounding = 20 * std::numeric_limits<float>::epsilon() * 10;  // sums of five terms below 10
  EXPECT_NEAR(full[0], plain[0] + 6.0F, kRounding);
  EXPECT_EQ(full[1], plain[1]);
  EXPECT_NEAR(full[2], plain[2] - 8.5F, kRounding);
  EXPECT_EQ(sizeof(without), sizeof(network));
}

/// Returns a network with 5 inputs and 3 outputs, 2 of which fall back, and the same network without a fallback.
auto maps_with_and_without_fallback() {
  std::mt19937 random(8);
  const auto first = random_dense<float, 5, 16>(random);
  const auto last = random_dense<float, 16, 3>(random);
  const auto network = make_mlp<Activation::kTanh>(first, last);
  using Rows = FallbackRows<float, 5, 2>;
  using Map = LearnedMap<decltype(network), NoLinearPath, NoErrorHead, NoClockProducts, Rows>;
  const Rows rows{{0, 2}, {{1, -2, 0.5F, 0, 3}, {0, 0, 0.25F, 0, -1}}, {0.3F, -0.2F}, {2.0F, 0.5F}};
  return std::pair{Map{network, {}, {}, {}, rows}, LearnedMap<decltype(network)>{network}};
}

TEST(Fallback, FollowsItsEquationForOutputsWithARowAndLeavesOthersUnchanged) {
  const auto [with, without] = maps_with_and_without_fallback();
  std::mt19937 random(12);
  double nearest = 1e9, farthest = 0.0;  // distances from the row, divided by its reach
  for (int k = 0; k < 200; ++k) {
    float in[5], out[3], plain[3];
    for (float& value : in) value = testing::uniform<float>(random, -2.0, 2.0);
    with.evaluate(in, out);
    without.evaluate(in, plain);
    EXPECT_EQ(out[1], plain[1]);
    for (int f = 0; f < 2; ++f) {
      const int o = with.fallback.outputs[f];
      double row = static_cast<double>(with.fallback.offset[f]);
      for (int i = 0; i < 5; ++i) row += static_cast<double>(with.fallback.weights[f][i]) * static_cast<double>(in[i]);
      const double distance = static_cast<double>(plain[o]) - row;
      const double ratio = distance * static_cast<double>(with.fallback.per_reach[f]);
      EXPECT_NEAR(static_cast<double>(out[o]), row + distance / (1.0 + ratio * ratio), 1e-5);  // sums below 20 in float
      nearest = std::min(nearest, std::fabs(ratio));
      farthest = std::max(farthest, std::fabs(ratio));
    }
  }
  EXPECT_LT(nearest, 0.1) << "control: the network decided somewhere";
  EXPECT_GT(farthest, 5.0) << "control: the row decided somewhere";
  EXPECT_EQ(sizeof(without), sizeof(without.mlp)) << "costs nothing where unused";
}

TEST(Fallback, IsFiniteAndWithinHalfAReachOfTheRowForTheLargestNumbersOfAModel) {
  constexpr float kNumbers[] = {0.0F, 1e-30F, 1.0F, 1e15F, 1e30F};  // up to the limits of validate()
  constexpr double kRounding = 4.0 * static_cast<double>(std::numeric_limits<float>::epsilon());
  for (const float size : kNumbers)
    for (const float row_size : kNumbers)
      for (const float reach : {1e-30F, 1e-3F, 1.0F, 1e30F})
        for (const float estimate : {size, -size})
          for (const float row : {row_size, -row_size}) {
            const float result = fall_back<Arithmetic::kDeterministic>(estimate, row, 1.0F / reach);
            ASSERT_TRUE(std::isfinite(result)) << estimate << ", row " << row << ", reach " << reach;
            const double off = std::fabs(static_cast<double>(result) - static_cast<double>(row));
            EXPECT_LE(off, 0.5 * (1.0 + kRounding) * static_cast<double>(reach) +
                               kRounding * std::fabs(static_cast<double>(row)))
                << estimate << ", row " << row << ", reach " << reach;
          }
}

TEST(Fallback, InABatchHasTheBitsOfEachPlantAlone) {
  constexpr int kPlants = 6;
  const auto map = maps_with_and_without_fallback().first;
  std::mt19937 random(13);
  float in[5 * kPlants], out[3 * kPlants];
  for (float& value : in) value = testing::uniform<float>(random, -2.0, 2.0);
  evaluate_batch<Arithmetic::kDeterministic, kPlants>(map, in, out);
  for (int n = 0; n < kPlants; ++n) {
    float one_in[5], one_out[3];
    for (int i = 0; i < 5; ++i) one_in[i] = in[i * kPlants + n];
    map.evaluate<Arithmetic::kDeterministic>(one_in, one_out);
    for (int o = 0; o < 3; ++o) EXPECT_EQ(out[o * kPlants + n], one_out[o]) << "plant " << n << ", output " << o;
  }
}

template <Activation kKind>
void expect_finite_differences() {
  constexpr double kStep = 1e-5;       // rounding 1e-16 / 1e-5, truncation 1e-10
  constexpr double kTolerance = 1e-6;  // slopes are those of tanh, values those of a rational function within 4e-8
  std::mt19937 random(9);
  const auto first = random_dense<double, 4, 16>(random);
  const auto last = random_dense<double, 16, 3>(random);
  const auto network = make_mlp<kKind>(first, last);
  using Path = LinearPath<double, 4, 3>;
  const LearnedMap<decltype(network), Path> map{network, Path{{{1, -2, 0.5, 0}, {0, 0, 0, 0}, {0.1, 0, 0, 3}}}};
  for (int k = 0; k < 50; ++k) {
    double in[4], direction[4], ahead[4], behind[4], out[3], high[3], low[3];
    for (int i = 0; i < 4; ++i) {
      in[i] = testing::uniform<double>(random, -1.5, 1.5);
      direction[i] = testing::uniform<double>(random, -1.0, 1.0);
      ahead[i] = in[i] + kStep * direction[i];
      behind[i] = in[i] - kStep * direction[i];
    }
    jvp(map, in, direction, out);
    map.evaluate(ahead, high);
    map.evaluate(behind, low);
    for (int o = 0; o < 3; ++o) EXPECT_NEAR(out[o], (high[o] - low[o]) / (2 * kStep), kTolerance);
  }
}

TEST(Jvp, AgreesWithFiniteDifferencesWithItsLinearPath) {
  expect_finite_differences<Activation::kTanh>();
  expect_finite_differences<Activation::kRelu>();  // no kink lies within 1e-5 of these 800 pre-activations
  expect_finite_differences<Activation::kSilu>();
}

TEST(Jvp, IsZeroInTheZeroDirection) {
  std::mt19937 random(2);
  const auto network =
      make_mlp<Activation::kSilu>(random_dense<float, 3, 20>(random), random_dense<float, 20, 4>(random));
  const float in[3] = {0.5F, -30.0F, 1e6F}, none[3] = {};
  float out[4];
  jvp(network, in, none, out);
  for (const float value : out) EXPECT_EQ(value, 0.0F);
}

}  // namespace
}  // namespace nlo
