// SPDX-License-Identifier: MIT
// The inverse map against the same network in double, within a bound that is carried along through the layers.
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
  const auto draw = [&random] {  // never near zero, so that each weight matters
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

/// Values and how far they may be off.
struct Signal {
  std::vector<double> value, error;
};

template <class Scalar, int kIn, int kOut>
Signal affine(const Dense<Scalar, kIn, kOut>& layer, const Signal& in) {
  constexpr double kEps = static_cast<double>(std::numeric_limits<Scalar>::epsilon());
  Signal out;
  for (int o = 0; o < kOut; ++o) {
    double sum = static_cast<double>(layer.bias[o]), magnitude = std::fabs(sum), error = 0.0;
    for (int i = 0; i < kIn; ++i) {
      const auto from = static_cast<std::size_t>(i);
      const double weight = static_cast<double>(layer.weights[o][i]);
      sum += weight * in.value[from];
      magnitude += std::fabs(weight * in.value[from]);
      error += std::fabs(weight) * in.error[from];
    }
    out.value.push_back(sum);
    out.error.push_back(error + (kIn + 2) * kEps * (magnitude + error));
  }
  return out;
}

/// Slopes are at most 1 (tanh, relu) or 1.1 (silu); silu's own error grows with |v|.
template <Activation kKind>
Signal activated(Signal s) {
  for (std::size_t i = 0; i < s.value.size(); ++i) {
    const double v = s.value[i];
    if (kKind == Activation::kTanh) s.value[i] = std::tanh(v), s.error[i] += kTanhMaxError;
    if (kKind == Activation::kRelu) s.value[i] = std::fmax(v, 0.0);
    if (kKind == Activation::kSilu) {
      s.value[i] = v / (1.0 + std::exp(-v));
      s.error[i] = 1.1 * s.error[i] + (1.0 + std::fabs(v)) * kTanhMaxError;
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

/// Worst |flown - reference| / allowed over random inputs: below 1 where they agree.
template <Activation kKind, class Network, class... Layers>
double disagreement(const Network& network, const Layers&... layers) {
  using Scalar = typename Network::Scalar;
  std::mt19937 random(77);
  double worst = 0.0;
  for (int k = 0; k < 20; ++k) {
    Scalar in[Network::kIn], out[Network::kOut];
    Signal signal;
    for (Scalar& value : in) {
      value = testing::uniform<Scalar>(random, -1.5, 1.5);
      signal.value.push_back(static_cast<double>(value));
      signal.error.push_back(0.0);
    }
    network.evaluate(in, out);
    const Signal expected = reference<kKind>(signal, layers...);
    for (std::size_t o = 0; o < Network::kOut; ++o) {
      worst = std::fmax(worst, std::fabs(static_cast<double>(out[o]) - expected.value[o]) / expected.error[o]);
    }
  }
  return worst;
}

template <class Scalar, Activation kKind>
void expect_parity() {
  std::mt19937 random(3);
  const auto a = random_dense<Scalar, 3, 50>(random);
  const auto b = random_dense<Scalar, 50, 17>(random);
  const auto c = random_dense<Scalar, 17, 5>(random);
  const auto d = random_dense<Scalar, 5, 8>(random);
  const auto e = random_dense<Scalar, 8, 2>(random);
  EXPECT_LT((disagreement<kKind>(make_mlp<kKind>(a, b, c, d, e), a, b, c, d, e)), 1.0);
  EXPECT_LT((disagreement<kKind>(make_mlp<kKind>(d, e), d, e)), 1.0);
  EXPECT_LT((disagreement<kKind>(make_mlp<kKind>(c), c)), 1.0);  // one layer: linear
  EXPECT_LT((disagreement<kKind>(make_mlp<kKind>(a), a)), 1.0);
}

TEST(Mlp, MeetsTheSameNetworkInDouble) {
  expect_parity<float, Activation::kTanh>();
  expect_parity<float, Activation::kRelu>();
  expect_parity<float, Activation::kSilu>();
  expect_parity<double, Activation::kTanh>();
  expect_parity<double, Activation::kRelu>();
  expect_parity<double, Activation::kSilu>();
}

TEST(Mlp, ParityNoticesAnyWeightWithAWrongSign) {  // the control of the test above
  constexpr auto kKind = Activation::kTanh;
  std::mt19937 random(4);
  const auto first = random_dense<float, 3, 9>(random);
  const auto last = random_dense<float, 9, 2>(random);
  ASSERT_LT((disagreement<kKind>(make_mlp<kKind>(first, last), first, last)), 1.0);
  auto wrong_first = first;
  auto wrong_last = last;
  const auto notices = [&](float& weight) {
    weight = -weight;
    const double worst = disagreement<kKind>(make_mlp<kKind>(wrong_first, wrong_last), first, last);
    weight = -weight;
    return worst > 1.0;
  };
  const auto notices_all = [&](auto& layer) {
    for (auto& row : layer.weights) {
      for (float& weight : row) EXPECT_TRUE(notices(weight));
    }
    for (float& bias : layer.bias) EXPECT_TRUE(notices(bias));
  };
  notices_all(wrong_first);
  notices_all(wrong_last);
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

}  // namespace
}  // namespace nlo
