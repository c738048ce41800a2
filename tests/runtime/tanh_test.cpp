// SPDX-License-Identifier: MIT
// The rational tanh over all floats (or every NLO_FLOAT_STRIDEth), compared with the C library in double.
#include <nlo/kernels/activation.h>
#include <nlo/kernels/batch.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <thread>
#include <vector>

namespace nlo {
namespace {

constexpr std::uint32_t kStride = NLO_FLOAT_STRIDE;
constexpr std::uint32_t kInfinity = 0x7f800000U;
constexpr int kLanes = simd::kLanes<float>;
using Pack = simd::Pack<float>;

static_assert(tanh_rational(0.0F) == 0.0F);
static_assert(tanh_rational(1e30F) == -tanh_rational(-1e30F));
static_assert(tanh_rational(0x1p-1074) == 0x1p-1074 && tanh_rational(1e300) <= 1.0);

/// tanh of a float as a double, exact to 1e-16; quick where a series or 1 is enough.
double exact(float x) {
  const double v = static_cast<double>(x);
  if (v < 0x1p-12) return v - v * v * v / 3;
  return v > 20.0 ? 1.0 : std::tanh(v);
}

enum class How { kAlone, kAwaited, kMany };

template <Activation kKind, How kHow, class T>
T tanh_by(T v) {
#if NLO_HAS_VECTORS
  if constexpr (kHow == How::kMany) return kernels::native::activate_many<kKind, Arithmetic::kFast>(v);
#endif
  return activate<kKind, Arithmetic::kFast, kHow == How::kAwaited>(v);
}

struct Findings {
  double worst = 0.0;         ///< |tanh_rational - tanh|
  float largest = 0.0F;       ///< |tanh_rational|
  float worst_drop = 0.0F;    ///< largest decrease while x increases
  std::uint64_t not_odd = 0;  ///< inputs with f(-x) != -f(x)
  std::uint64_t seen = 0;
};

/// Positive floats with bits in [first, last), with both signs.
template <class T, Activation kKind, How kHow>
Findings sweep(std::uint32_t first, std::uint32_t last) {
  constexpr int kBlock = 1024;
  float x[kBlock], f[kBlock], f_negative[kBlock];
  Findings found;
  float before = 0.0F;
  for (std::uint64_t base = first; base < last; base += std::uint64_t{kBlock} * kStride) {
    int n = 0;
    for (; n < kBlock && base + std::uint64_t{static_cast<std::uint32_t>(n)} * kStride < last; ++n) {
      x[n] = std::bit_cast<float>(static_cast<std::uint32_t>(base + static_cast<std::uint32_t>(n) * kStride));
    }
    for (int i = n; i < kBlock; ++i) x[i] = x[n - 1];
    constexpr int kWidth = static_cast<int>(sizeof(T) / sizeof(float));
    for (int i = 0; i < kBlock; i += kWidth) {
      const T v = simd::load<T>(x + i);
      simd::store(f + i, tanh_by<kKind, kHow>(v));
      simd::store(f_negative + i, tanh_by<kKind, kHow>(-v));
    }
    for (int i = 0; i < n; ++i) {
      found.worst = std::max(found.worst, std::fabs(static_cast<double>(f[i]) - exact(x[i])));
      found.largest = std::max(found.largest, std::fabs(f[i]));
      found.worst_drop = std::max(found.worst_drop, before - f[i]);
      found.not_odd +=
          std::bit_cast<std::uint32_t>(f[i]) != (std::bit_cast<std::uint32_t>(f_negative[i]) ^ 0x80000000U);
      before = f[i];
    }
    found.seen += static_cast<std::uint64_t>(n);
  }
  return found;
}

/// All of [0, inf], divided among two threads in slices that are small enough to balance.
template <class T, Activation kKind, How kHow>
Findings sweep_all() {
  constexpr std::uint32_t kSlices = 510, kSlice = (kInfinity / kSlices / kStride) * kStride;
  std::vector<Findings> slices(kSlices + 1);
  const auto work = [&](std::uint32_t parity) {
    for (std::uint32_t s = parity; s <= kSlices; s += 2) {
      slices[s] = sweep<T, kKind, kHow>(s * kSlice, s == kSlices ? kInfinity + 1 : (s + 1) * kSlice);
    }
  };
  std::thread other(work, 1);
  work(0);
  other.join();
  Findings all;
  for (const Findings& slice : slices) {
    all.worst = std::max(all.worst, slice.worst);
    all.largest = std::max(all.largest, slice.largest);
    all.worst_drop = std::max(all.worst_drop, slice.worst_drop);
    all.not_odd += slice.not_odd;
    all.seen += slice.seen;
  }
  return all;
}

template <class T, Activation kKind, How kHow = How::kAlone>
void expect_good(double max_error) {
  // Numerator, denominator and quotient round, so neighbours below 1 may be in the wrong order by a few units
  // (measured: 6). The cheaper fits also oscillate about tanh where it is flat.
  const double max_drop = kKind == Activation::kTanh ? 12 * 0x1p-24 : max_error;
  const Findings found = sweep_all<T, kKind, kHow>();
  EXPECT_GE(found.seen, kInfinity / kStride);
  EXPECT_LE(found.worst, max_error);
  EXPECT_LE(found.largest, 1.0F);
  EXPECT_LE(static_cast<double>(found.worst_drop), max_drop);
  EXPECT_EQ(found.not_odd, 0U);
  ::testing::Test::RecordProperty("worst", std::to_string(found.worst * 1e9) + "e-9");
}

TEST(TanhRational, IsWithinItsBoundOddAndMonotoneOverTheFloats) {
  expect_good<float, Activation::kTanh>(kTanhMaxError);
}

TEST(TanhRational, IsWithinItsBoundOddAndMonotoneOverTheFloatsInPacks) {
  expect_good<Pack, Activation::kTanh>(kTanhMaxError);
}

TEST(TanhRational, IsWithinItsBoundOddAndMonotoneOverTheFloatsWithShortLatency) {
  expect_good<float, Activation::kTanh, How::kAwaited>(kTanhMaxError);
  expect_good<Pack, Activation::kTanh, How::kAwaited>(kTanhMaxError);
  expect_good<Pack, Activation::kTanh5e6, How::kAwaited>(kTanh5e6MaxError);
}

TEST(TanhRational, IsWithinItsBoundOddAndMonotoneOverDenseFloats) {
  expect_good<Pack, Activation::kTanh, How::kMany>(kTanhMaxError);
  expect_good<Pack, Activation::kTanh5e6, How::kMany>(kTanh5e6MaxError);
  expect_good<Pack, Activation::kTanh5e5, How::kMany>(kTanh5e5MaxError);
}

TEST(TanhRational, CheaperVersionsAreWithinTheirBoundsAndOddOverTheFloats) {
  expect_good<float, Activation::kTanh5e6>(kTanh5e6MaxError);
  expect_good<Pack, Activation::kTanh5e6>(kTanh5e6MaxError);
  expect_good<float, Activation::kTanh5e5>(kTanh5e5MaxError);
  expect_good<Pack, Activation::kTanh5e5>(kTanh5e5MaxError);
}

TEST(TanhRational, GivesANumberForNan) {
  for (const std::uint32_t bits : {0x7f800001U, 0x7fc00000U, 0x7fffffffU, 0xff800001U, 0xffc00000U, 0xffffffffU}) {
    const float nan = std::bit_cast<float>(bits);
    EXPECT_LE(std::fabs(tanh_rational(nan)), 1.0F);
    float lanes[kLanes];
    simd::store(lanes, tanh_rational(simd::broadcast<Pack>(nan)));
    for (const float lane : lanes) EXPECT_LE(std::fabs(lane), 1.0F);
    simd::store(lanes, awaited_tanh(simd::broadcast<Pack>(nan)));
    for (const float lane : lanes) EXPECT_LE(std::fabs(lane), 1.0F);
    simd::store(lanes,
                tanh_by<Activation::kTanh, How::kMany>(nan + simd::broadcast<Pack>(0.0F)));  // a sum gives a quiet NaN
    for (const float lane : lanes) EXPECT_LE(std::fabs(lane), 1.0F);
  }
}

/// tanh_rational of doubles, by lanes of a pack or as scalars.
template <class T, Arithmetic kArithmetic>
double in_double(double x) {
  if constexpr (sizeof(T) == sizeof(double)) {
    return tanh_rational<Activation::kTanh, kArithmetic>(x);
  } else {
    double lanes[sizeof(T) / sizeof(double)];
    simd::store(lanes, tanh_rational<Activation::kTanh, kArithmetic>(simd::broadcast<T>(x)));
    return lanes[0];
  }
}

/// Calls check(x, of(x)) densely where tanh is curved, coarsely in each binade, and far outside.
template <class T, Arithmetic kArithmetic, class Check>
void over_doubles(Check check) {
  const auto at = [&](double x) { check(x, in_double<T, kArithmetic>(x)); };
  constexpr double kOffGrid = 1.0 / 3;
  for (double x = 0x1p-12 * kOffGrid; x < 25.0; x += 0x1p-12 * kOffGrid) at(x);
  for (int exponent = -1074; exponent < 1024; ++exponent)
    for (const double mantissa : {1.0, 1.1, 1.37, 1.5, 1.83}) at(std::ldexp(mantissa, exponent));
  for (const double x : {0.0, std::numeric_limits<double>::infinity()}) at(x);
}

template <class T, Arithmetic kArithmetic>
void expect_good_in_double() {
  // P, Q, their quotient and s are rounded. Measured: 7 units of 2^-53, relative to tanh.
  constexpr double kRelative = 9 * 0x1p-53;
  double worst = 0.0, worst_relative = 0.0, largest = 0.0;
  int not_odd = 0;
  over_doubles<T, kArithmetic>([&](double x, double f) {
    const long double exact = std::tanh(static_cast<long double>(x));
    const double off = static_cast<double>(std::fabs(static_cast<long double>(f) - exact));
    worst = std::max(worst, off);
    if (x >= std::numeric_limits<double>::min())
      worst_relative = std::max(worst_relative, off / static_cast<double>(exact));
    largest = std::max(largest, std::fabs(f));
    not_odd += in_double<T, kArithmetic>(-x) != -f;
  });
  EXPECT_LE(worst, kTanhMaxErrorDouble);
  EXPECT_LE(worst_relative, kRelative);
  EXPECT_LE(largest, 1.0);
  EXPECT_EQ(not_odd, 0);
}

TEST(TanhRational, InDoubleIsAccurateToItsLastPlacesAndOdd) {
  expect_good_in_double<double, Arithmetic::kFast>();
  expect_good_in_double<double, Arithmetic::kDeterministic>();
  expect_good_in_double<simd::Pack<double>, Arithmetic::kFast>();
  expect_good_in_double<simd::Pack<double>, Arithmetic::kDeterministic>();
}

TEST(TanhRational, InDoubleGivesANumberForNan) {
  for (const double nan : {std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::quiet_NaN()})
    EXPECT_LE(std::fabs(tanh_rational(nan)), 1.0);
}

}  // namespace
}  // namespace nlo
