// SPDX-License-Identifier: MIT
// The forward-mode product of a learned map: against the layers' derivatives in double, and against finite differences.
#include <nlo/jvp.h>
#include <nlo/mlp.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/runtime/testing.h"

namespace nlo {
namespace {

template <class Scalar, int kIn, int kOut>
Dense<Scalar, kIn, kOut> random_dense(std::mt19937& random) {
  Dense<Scalar, kIn, kOut> layer{};
  for (auto& row : layer.weights) {
    for (Scalar& weight : row) weight = testing::uniform<Scalar>(random, -1.7, 1.7) / std::sqrt(Scalar(kIn));
  }
  for (Scalar& bias : layer.bias) bias = testing::uniform<Scalar>(random, -0.5, 0.5);
  return layer;
}

/// A value and its tangent, by the definition of each layer.
struct Dual {
  std::vector<double> value, tangent;
};

template <class Scalar, int kIn, int kOut>
Dual affine(const Dense<Scalar, kIn, kOut>& layer, const Dual& in) {
  Dual out;
  for (int o = 0; o < kOut; ++o) {
    double v = static_cast<double>(layer.bias[o]), d = 0.0;
    for (int i = 0; i < kIn; ++i) {
      const auto from = static_cast<std::size_t>(i);
      v += static_cast<double>(layer.weights[o][i]) * in.value[from];
      d += static_cast<double>(layer.weights[o][i]) * in.tangent[from];
    }
    out.value.push_back(v);
    out.tangent.push_back(d);
  }
  return out;
}

template <Activation kKind>
Dual activated(Dual s) {
  for (std::size_t i = 0; i < s.value.size(); ++i) {
    const double v = s.value[i], sigmoid = 1.0 / (1.0 + std::exp(-v)), tanh = std::tanh(v);
    if (kKind == Activation::kTanh) s.value[i] = tanh, s.tangent[i] *= 1.0 - tanh * tanh;
    if (kKind == Activation::kRelu) s.value[i] = std::fmax(v, 0.0), s.tangent[i] *= v > 0.0 ? 1.0 : 0.0;
    if (kKind == Activation::kSilu) s.value[i] = v * sigmoid, s.tangent[i] *= sigmoid * (1.0 + v * (1.0 - sigmoid));
  }
  return s;
}

template <Activation kKind, class Last>
Dual reference(const Dual& in, const Last& last) {
  return affine(last, in);
}
template <Activation kKind, class First, class... Rest>
Dual reference(const Dual& in, const First& first, const Rest&... rest) requires(sizeof...(Rest) > 0) {
  return reference<kKind>(activated<kKind>(affine(first, in)), rest...);
}

/// Largest difference to the reference over random inputs and directions.
template <Activation kKind, class Network, class... Layers>
double disagreement(const Network& network, const Layers&... layers) {
  using Scalar = typename Network::Scalar;
  std::mt19937 random(5);
  double worst = 0.0;
  for (int k = 0; k < 50; ++k) {
    Scalar in[Network::kIn], direction[Network::kIn], out[Network::kOut];
    Dual dual;
    for (int i = 0; i < Network::kIn; ++i) {
      in[i] = testing::uniform<Scalar>(random, -1.5, 1.5);
      direction[i] = testing::uniform<Scalar>(random, -1.0, 1.0);
      dual.value.push_back(static_cast<double>(in[i]));
      dual.tangent.push_back(static_cast<double>(direction[i]));
    }
    jvp(network, in, direction, out);
    const Dual expected = reference<kKind>(dual, layers...);
    for (std::size_t o = 0; o < Network::kOut; ++o) {
      worst = std::fmax(worst, std::fabs(static_cast<double>(out[o]) - expected.tangent[o]));
    }
  }
  return worst;
}

// Tangents are of size one. Two activation layers each pass an error of the rational tanh (5e-7, and 2 times that in
// the slope) and some 50 roundings of float; double has the rational's 4e-8 alone.
template <class Scalar>
constexpr double kTolerance = sizeof(Scalar) == 4 ? 2e-5 : 1e-6;

template <class Scalar, Activation kKind>
void expect_parity() {
  std::mt19937 random(3);
  const auto a = random_dense<Scalar, 3, 50>(random);
  const auto b = random_dense<Scalar, 50, 17>(random);
  const auto c = random_dense<Scalar, 17, 5>(random);
  EXPECT_LT((disagreement<kKind>(make_mlp<kKind>(a, b, c), a, b, c)), kTolerance<Scalar>);
  EXPECT_LT((disagreement<kKind>(make_mlp<kKind>(b, c), b, c)), kTolerance<Scalar>);
  EXPECT_LT((disagreement<kKind>(make_mlp<kKind>(c), c)), kTolerance<Scalar>);  // one layer: linear
}

TEST(Jvp, MeetsTheDerivativeInDouble) {
  expect_parity<float, Activation::kTanh>();
  expect_parity<float, Activation::kRelu>();
  expect_parity<float, Activation::kSilu>();
  expect_parity<double, Activation::kTanh>();
  expect_parity<double, Activation::kRelu>();
  expect_parity<double, Activation::kSilu>();
}

TEST(Jvp, ParityNoticesAnyWrongWeight) {  // the control of the test above
  constexpr auto kKind = Activation::kTanh;
  std::mt19937 random(4);
  const auto first = random_dense<float, 3, 9>(random);
  const auto last = random_dense<float, 9, 2>(random);
  ASSERT_LT((disagreement<kKind>(make_mlp<kKind>(first, last), first, last)), kTolerance<float>);
  auto wrong_first = first;
  auto wrong_last = last;
  const auto notices = [&](float& weight) {
    const float good = weight;
    weight *= 1.01F;
    const double worst = disagreement<kKind>(make_mlp<kKind>(wrong_first, wrong_last), first, last);
    weight = good;
    return worst > kTolerance<float>;
  };
  for (auto& row : wrong_first.weights) {
    for (float& weight : row) EXPECT_TRUE(notices(weight));
  }
  for (float& bias : wrong_first.bias) EXPECT_TRUE(notices(bias));
  for (auto& row : wrong_last.weights) {
    for (float& weight : row) EXPECT_TRUE(notices(weight));
  }
}

template <Activation kKind>
void expect_finite_differences() {
  constexpr double kStep = 1e-5;       // rounding 1e-16 / 1e-5, truncation 1e-10
  constexpr double kTolerance = 1e-6;  // the slope is that of tanh, the value a rational 4e-8 from it
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

TEST(Jvp, MeetsFiniteDifferencesWithItsLinearPath) {
  expect_finite_differences<Activation::kTanh>();
  expect_finite_differences<Activation::kRelu>();  // no kink lies within 1e-5 of these 800 pre-activations
  expect_finite_differences<Activation::kSilu>();
}

TEST(Jvp, OfNoDirectionIsZero) {
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
