// SPDX-License-Identifier: MIT
// The matrix-vector kernels against plain loops: every pair of awkward sizes, both layouts, float and double, unaligned
// data, nothing read or written outside. Compiled for several instruction sets.
#include <nlo/kernels/generic.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "tests/runtime/testing.h"

namespace nlo {
namespace {

constexpr int kSizes[] = {1, 2, 3, 5, 7, 8, 9, 15, 16, 17, 31, 50, 64, 65};
constexpr std::size_t kCount = std::size(kSizes);

/// n random scalars that end where the allocation ends (a sanitizer sees what is read beyond) and start unaligned.
template <class Scalar>
struct Unaligned {
  std::vector<Scalar> values;
  std::size_t offset;
  Unaligned(int n, std::size_t shift, std::mt19937& random)
      : values(static_cast<std::size_t>(n) + shift), offset(shift) {
    for (Scalar& value : values) value = testing::uniform<Scalar>(random, -1, 1);
  }
  Scalar* data() { return values.data() + offset; }
};

/// What the plain loop gives, and how far rounding may take another order of summation.
struct Expected {
  double value;
  double rounding;
};

template <class Scalar>
Expected plain(const Scalar* weights, Scalar bias, const Scalar* in, int n_in, int stride) {
  const long double start = static_cast<long double>(bias);
  long double sum = start, magnitude = std::fabs(start);
  for (int i = 0; i < n_in; ++i) {
    const long double term = static_cast<long double>(weights[i * stride]) * static_cast<long double>(in[i]);
    sum += term;
    magnitude += std::fabs(term);
  }
  // Each of n_in products and sums rounds by half an epsilon of at most `magnitude`.
  const double eps = static_cast<double>(std::numeric_limits<Scalar>::epsilon());
  return {static_cast<double>(sum), (n_in + 2) * eps * static_cast<double>(magnitude)};
}

/// One instantiation, as a value: what is checked stays out of the templates, which take long enough to compile.
template <class Scalar>
struct Kernel {
  int n_in, n_out;
  bool by_columns;
  void (*run)(const Scalar* weights, const Scalar* bias, const Scalar* in, Scalar* out);
};

template <class Scalar, int kIn, int kOut, class Function>
constexpr Kernel<Scalar> kernel() {
  return {kIn, kOut, kernels::kByColumns<kIn, kOut>,
          [](const Scalar* weights, const Scalar* bias, const Scalar* in, Scalar* out) {
            kernels::dense<Scalar, kIn, kOut>(weights, bias, in, out, Function{});
          }};
}

template <class Scalar>
void check(const Kernel<Scalar>& kernel, double (*reference)(double), double slack) {
  constexpr int kGuard = 16;
  const int n_in = kernel.n_in, n_out = kernel.n_out;
  const auto where = std::to_string(n_in) + " -> " + std::to_string(n_out);
  std::mt19937 random(static_cast<std::uint32_t>(n_in * 100 + n_out));
  for (std::size_t shift = 0; shift < 4; ++shift) {
    Unaligned<Scalar> weights(n_in * n_out, shift, random), bias(n_out, (shift + 1) % 4, random);
    Unaligned<Scalar> in(n_in, (shift + 2) % 4, random), out(n_out + 2 * kGuard, shift, random);
    const auto before = out.values;
    kernel.run(weights.data(), bias.data(), in.data(), out.data() + kGuard);
    for (int o = 0; o < n_out; ++o) {
      const Scalar* first = weights.data() + (kernel.by_columns ? o : o * n_in);
      const Expected sum = plain(first, bias.data()[o], in.data(), n_in, kernel.by_columns ? n_out : 1);
      ASSERT_NEAR(static_cast<double>(out.data()[kGuard + o]), reference(sum.value), sum.rounding + slack)
          << where << ", output " << o << ", shift " << shift;
    }
    const auto first = static_cast<std::ptrdiff_t>(shift) + kGuard;
    ASSERT_TRUE(std::equal(before.begin(), before.begin() + first, out.values.begin())) << where;
    ASSERT_TRUE(std::equal(before.begin() + first + n_out, before.end(), out.values.begin() + first + n_out)) << where;
  }
}

template <class Scalar>
struct Kernels : ::testing::Test {};
using Scalars = ::testing::Types<float, double>;
TYPED_TEST_SUITE(Kernels, Scalars);

TYPED_TEST(Kernels, MeetAPlainLoopForEveryShapeAndStayInBounds) {
  static constexpr auto kAll = []<std::size_t... kPair>(std::index_sequence<kPair...>) {
    return std::array{kernel<TypeParam, kSizes[kPair / kCount], kSizes[kPair % kCount], kernels::Identity>()...};
  }
  (std::make_index_sequence<kCount * kCount>{});
  for (const auto& one : kAll) {
    check<TypeParam>(
        one, [](double v) { return v; }, 0.0);
  }
}

/// Outputs of both layouts, with and without a last, partial register.
template <class Scalar, class Function>
constexpr std::array kActivated = {kernel<Scalar, 7, 2, Function>(), kernel<Scalar, 7, 8, Function>(),
                                   kernel<Scalar, 7, 17, Function>(), kernel<Scalar, 7, 50, Function>()};

TYPED_TEST(Kernels, ApplyTheActivationToEveryOutput) {
  for (const auto& one : kActivated<TypeParam, kernels::Activate<Activation::kTanh>>) {
    check<TypeParam>(
        one, [](double v) { return std::tanh(v); }, kTanhMaxError);
  }
  for (const auto& one : kActivated<TypeParam, kernels::Activate<Activation::kRelu>>) {
    check<TypeParam>(
        one, [](double v) { return std::max(v, 0.0); }, 0.0);
  }
}

// A model's bytes must not depend on the target: the layout follows from the shape alone.
static_assert(kernels::kByColumns<1, 8> && kernels::kByColumns<50, 50> && !kernels::kByColumns<50, 7>);
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
