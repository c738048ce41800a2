// SPDX-License-Identifier: MIT
// Dense layers compared with plain loops: each pair of awkward sizes, hidden and last layers, float, double and 16-bit
// weights. Nothing is read or written outside, and padding is zero. Compiled for several instruction sets.
#include <nlo/kernels/weight.h>
#include <nlo/mlp.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "tests/runtime/testing.h"

namespace nlo {
namespace {

template <class T>
T random_value(std::mt19937& random) {
  return T(testing::uniform<typename ComputesIn<T>::Type>(random, -1, 1));
}

/// n random scalars that end where the allocation ends, so that a sanitizer detects reads beyond; zeros after the first
/// `filled`.
template <class Scalar>
std::vector<Scalar> padded_values(int n, int filled, std::mt19937& random) {
  std::vector<Scalar> values(static_cast<std::size_t>(n));
  for (int i = 0; i < filled; ++i) values[static_cast<std::size_t>(i)] = random_value<Scalar>(random);
  return values;
}

/// Result of the plain loop, and a bound of the rounding error for another order of summation.
struct Expected {
  double value;
  double rounding;
};

template <class Weight, int kIn, int kOut>
Expected plain(const Dense<Weight, kIn, kOut>& layer, int o, const typename ComputesIn<Weight>::Type* in) {
  using Scalar = typename ComputesIn<Weight>::Type;
  const long double start = static_cast<long double>(layer.bias[o]);
  long double sum = start, magnitude = std::fabs(start);
  for (int i = 0; i < kIn; ++i) {
    const long double term =
        static_cast<long double>(static_cast<Scalar>(layer.weights[o][i])) * static_cast<long double>(in[i]);
    sum += term;
    magnitude += std::fabs(term);
  }
  // Each of kIn products and sums rounds by half an epsilon of at most `magnitude`.
  const double eps = static_cast<double>(std::numeric_limits<Scalar>::epsilon());
  return {static_cast<double>(sum), (kIn + 2) * eps * static_cast<double>(magnitude)};
}

template <class Weight, int kIn, int kOut>
Dense<Weight, kIn, kOut> random_layer(std::mt19937& random) {
  Dense<Weight, kIn, kOut> layer{};
  for (auto& row : layer.weights) {
    for (Weight& weight : row) weight = random_value<Weight>(random);
  }
  for (auto& bias : layer.bias) bias = random_value<typename ComputesIn<Weight>::Type>(random);
  return layer;
}

/// Compares one layer of the kernel, hidden with activation kKind or last, with plain loops.
template <class Weight, Activation kKind, Arithmetic kArithmetic, bool kLast, int kIn, int kOut>
void check_layer(double (*activation)(double), double slack) {
  using Scalar = typename ComputesIn<Weight>::Type;
  std::mt19937 random(static_cast<std::uint32_t>(kIn * 100 + kOut));
  const auto layer = random_layer<Weight, kIn, kOut>(random);
  const auto packed = std::make_unique<PackedDense<Weight, kIn, kOut>>(pack(layer));
  const auto in = padded_values<Scalar>(kernels::padded(kIn), kIn, random);
  constexpr int kGuard = 16, kWritten = kLast ? kOut : kernels::padded(kOut);
  auto out = padded_values<Scalar>(kWritten + 2 * kGuard, kWritten + 2 * kGuard, random);
  const auto before = out;
  kernels::layer<kKind, kArithmetic, kLast, kIn, kOut>(packed->weights, packed->bias, in.data(), out.data() + kGuard);
  const auto where = std::to_string(kIn) + " -> " + std::to_string(kOut) + (kLast ? ", last" : "");
  for (int o = 0; o < kOut; ++o) {
    const Expected sum = plain(layer, o, in.data());
    const double want = kLast ? sum.value : activation(sum.value);
    ASSERT_NEAR(static_cast<double>(out[static_cast<std::size_t>(kGuard + o)]), want, sum.rounding + slack)
        << where << ", output " << o;
  }
  for (int o = kOut; o < kWritten; ++o) ASSERT_EQ(out[static_cast<std::size_t>(kGuard + o)], Scalar(0)) << where;
  ASSERT_TRUE(std::equal(before.begin(), before.begin() + kGuard, out.begin())) << where;
  ASSERT_TRUE(std::equal(before.end() - kGuard, before.end(), out.end() - kGuard)) << where;
}

double relu(double v) {
  return std::max(v, 0.0);
}
double exact_tanh(double v) {
  return std::tanh(v);
}

template <class Scalar>
struct Kernels : ::testing::Test {};
using Weights = ::testing::Types<float, double, Bfloat16, Float16>;
TYPED_TEST_SUITE(Kernels, Weights);

template <class Weight, Arithmetic kArithmetic, int kIn, int kOut>
void check_shape() {
  check_layer<Weight, Activation::kRelu, kArithmetic, false, kIn, kOut>(relu, 0.0);
  check_layer<Weight, Activation::kRelu, kArithmetic, true, kIn, kOut>(relu, 0.0);
}

// The shapes cover these cases. Inputs: less than a block, one block or several, with and without a remainder. Outputs:
// each part of the layout alone and with others, one and several tiles, of one size and of two. Weights other than
// float only repeat the shapes for which they have their own code.
TYPED_TEST(Kernels, AgreeWithAPlainLoopAndStayInBounds) {
  constexpr auto kFast = Arithmetic::kFast;
  check_shape<TypeParam, kFast, 3, 50>();
  check_shape<TypeParam, kFast, 17, 15>();
  check_shape<TypeParam, kFast, 33, 65>();
  if constexpr (std::is_same_v<TypeParam, float>) {
    check_shape<TypeParam, kFast, 1, 1>();
    check_shape<TypeParam, kFast, 2, 8>();
    check_shape<TypeParam, kFast, 5, 4>();
    check_shape<TypeParam, kFast, 15, 7>();
    check_shape<TypeParam, kFast, 16, 16>();
    check_shape<TypeParam, kFast, 31, 31>();
    check_shape<TypeParam, kFast, 50, 2>();
    check_shape<TypeParam, kFast, 50, 50>();
    check_shape<TypeParam, kFast, 65, 5>();
    check_shape<TypeParam, kFast, 9, 191>();
  }
}

/// Outputs in each part of the layout, with few inputs and with many.
template <class Weight, Activation kKind, Arithmetic kArithmetic>
void check_activation(double (*activation)(double), double slack) {
  check_layer<Weight, kKind, kArithmetic, false, 7, 50>(activation, slack);
  check_layer<Weight, kKind, kArithmetic, false, 33, 31>(activation, slack);
}

TYPED_TEST(Kernels, ApplyTheActivationToEveryOutput) {
  constexpr auto kFast = Arithmetic::kFast, kDeterministic = Arithmetic::kDeterministic;
  check_activation<TypeParam, Activation::kRelu, kFast>(relu, 0.0);
  check_activation<TypeParam, Activation::kTanh, kFast>(exact_tanh, kTanhMaxError);
  check_activation<TypeParam, Activation::kTanh, kDeterministic>(exact_tanh, kTanhMaxError);
  check_activation<TypeParam, Activation::kTanh5e6, kFast>(exact_tanh, kTanh5e6MaxError);
  check_activation<TypeParam, Activation::kTanh5e5, kFast>(exact_tanh, kTanh5e5MaxError);
}

/// A network whose number of inputs is not a multiple of the vector length reads nothing after them.
TYPED_TEST(Kernels, NetworksAcceptAnyNumberOfInputs) {
  using Scalar = typename ComputesIn<TypeParam>::Type;
  std::mt19937 random(1);
  const auto first = random_layer<TypeParam, 17, 5>(random);
  const auto last = random_layer<TypeParam, 5, 2>(random);
  const auto in = padded_values<Scalar>(17, 17, random);
  Scalar out[2], hidden[5];
  make_mlp<Activation::kRelu>(first, last).evaluate(in.data(), out);
  for (int o = 0; o < 5; ++o) hidden[o] = static_cast<Scalar>(relu(plain(first, o, in.data()).value));
  for (int o = 0; o < 2; ++o) {
    constexpr double kRounding = 1e-5;  // about 100 rounding units of float for sums of a few units
    EXPECT_NEAR(static_cast<double>(out[o]), plain(last, o, hidden).value, kRounding);
  }
}

// The policy with one order: each output is summed from the bias on, input by input, and each operation rounds
// separately.
TYPED_TEST(Kernels, WithTheDeterministicPolicyAddInTheOrderOfInputs) {
  using Scalar = typename ComputesIn<TypeParam>::Type;
  constexpr int kIn = 37, kOut = 61;
  std::mt19937 random(2);
  const auto layer = random_layer<TypeParam, kIn, kOut>(random);
  const auto packed = pack(layer);
  const auto in = padded_values<Scalar>(kernels::padded(kIn), kIn, random);
  Scalar out[kOut];
  kernels::layer<Activation::kTanh, Arithmetic::kDeterministic, true, kIn, kOut>(packed.weights, packed.bias, in.data(),
                                                                                 out);
  for (int o = 0; o < kOut; ++o) {
    Scalar sum = layer.bias[o];
    for (int i = 0; i < kIn; ++i) {
      sum = rounded<Scalar>(static_cast<Scalar>(layer.weights[o][i]) * in[static_cast<std::size_t>(i)]) + sum;
    }
    EXPECT_EQ(out[o], sum) << o;
  }
}

template <class Weight, int kIn, int kOut>
void expect_a_layout_without_collisions() {
  using Layout = typename PackedDense<Weight, kIn, kOut>::Layout;
  std::vector<int> uses(static_cast<std::size_t>(Layout::kWeights));
  for (int o = 0; o < kOut; ++o) {
    const int first = Layout::weight_position(o, 0), step = Layout::weight_position(o, 1) - first;
    for (int i = 0; i < kIn; ++i) {
      ++uses.at(static_cast<std::size_t>(Layout::weight_position(o, i)));
      EXPECT_EQ(Layout::weight_position(o, i), first + i * step) << "pack() relies on this";
    }
  }
  EXPECT_EQ(std::count(uses.begin(), uses.end(), 1), kIn * kOut);
  EXPECT_EQ(std::count(uses.begin(), uses.end(), 0), Layout::kWeights - kIn * kOut);
}

TEST(Layout, HasOnePlaceForEachWeight) {
  expect_a_layout_without_collisions<float, 3, 50>();
  expect_a_layout_without_collisions<float, 50, 50>();
  expect_a_layout_without_collisions<float, 17, 191>();
  expect_a_layout_without_collisions<float, 5, 15>();
  expect_a_layout_without_collisions<float, 256, 2>();
}

TEST(Layout, IsTheSameForGeneratorsAndCompilers) {
  constexpr int kIn = 19, kOut = 139;
  std::mt19937 random(3);
  const auto layer = random_layer<float, kIn, kOut>(random);
  constexpr kernels::PanelLayout kLayout{kIn, kOut};
  auto written = std::make_unique<PanelDense<float, kIn, kOut>>();
  for (int o = 0; o < kOut; ++o) {
    for (int i = 0; i < kIn; ++i) written->weights[kLayout.weight_position(o, i)] = layer.weights[o][i];
    written->bias[o] = layer.bias[o];
  }
  const auto want = pack(layer), got = pack(*written);
  EXPECT_TRUE(std::equal(std::begin(want.weights), std::end(want.weights), std::begin(got.weights)));
  EXPECT_TRUE(std::equal(std::begin(want.bias), std::end(want.bias), std::begin(got.bias)));
}

/// Counts the 16-bit patterns of numbers that change when converted to float and back.
template <class Half>
std::size_t numbers_changed() {
  std::size_t changed = 0;
  for (std::uint32_t bits = 0; bits < 0x10000U; ++bits) {
    Half half;
    half.bits = static_cast<std::uint16_t>(bits);
    const float value = static_cast<float>(half);
    if (std::isfinite(value) && !(std::is_same_v<Half, Float16> && (bits & 0x7c00U) == 0x7c00U)) {
      changed += Half(value).bits != bits;
    }
  }
  return changed;
}

TEST(Weight, EveryNumberOf16BitsIsExactInFloat) {
  EXPECT_EQ(numbers_changed<Bfloat16>(), 0U);
  EXPECT_EQ(numbers_changed<Float16>(), 0U);
  static_assert(static_cast<float>(Float16(0x1p-24F)) == 0x1p-24F);
}

TEST(Weight, RoundsToNearestEven) {
  static_assert(static_cast<float>(Float16(1.0F + 0x1p-11F)) == 1.0F);                  // a tie, down to even
  static_assert(static_cast<float>(Float16(1.0F + 0x3p-11F)) == 1.0F + 0x1p-9F);        // a tie, up to even
  static_assert(static_cast<float>(Float16(1.0F + 0x1.2p-11F)) == 1.0F + 0x1p-10F);     // just above
  static_assert(Float16(65519.0F).bits == 0x7bff && Float16(65520.0F).bits == 0x7c00);  // the largest; too large
  static_assert(static_cast<float>(Float16(0x1.8p-25F)) == 0x1p-24F && Float16(-0x1p-25F).bits == 0x8000);
  for (const float large : {65520.0F, 1e6F, std::numeric_limits<float>::infinity()})
    EXPECT_EQ(Float16(large).bits, 0x7c00) << large;
  static_assert(static_cast<float>(Bfloat16(1.0F + 0x1p-8F)) == 1.0F);
  static_assert(static_cast<float>(Bfloat16(1.0F + 0x3p-8F)) == 1.0F + 0x1p-6F);
  for (std::uint32_t bits = 0; bits < 0x7f800000U; bits += 4099) {
    const float value = std::bit_cast<float>(bits);
    if (value > 65504.0F) break;
    const double ulp =
        std::max(std::exp2(std::floor(std::log2(std::max(static_cast<double>(value), 1e-300))) - 10), 0x1p-24);
    ASSERT_LE(std::fabs(static_cast<double>(static_cast<float>(Float16(value))) - static_cast<double>(value)), ulp / 2);
  }
}

#if defined(NLO_SCALAR_KERNELS)
static_assert(simd::kLanes<float> == 1 && simd::kLanes<double> == 1);
#elif defined(__AVX512F__)
static_assert(simd::kLanes<float> == 16);
#elif defined(__AVX2__)
static_assert(simd::kLanes<float> == 8);
#elif defined(__SSE2__)
static_assert(simd::kLanes<float> == 4);
#endif

}  // namespace
}  // namespace nlo
