// SPDX-License-Identifier: MIT
#include "trainer/gradients/nn/block_products.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "trainer/base/aligned_vector.h"
#include "trainer/base/random.h"

namespace nlo::trainer {
namespace {

template <class Scalar>
AlignedVector<Scalar> drawn(int count, std::uint64_t seed) {
  RandomLanes random(seed);
  AlignedVector<Scalar> values;
  for (RandomLanes::Floats u{}; static_cast<int>(values.size()) < count;) {
    random.uniform(u.data());
    for (const float each : u) values.push_back(static_cast<Scalar>(2.0F * each - 1.0F));
  }
  return values;
}

/// W (`rows` x `columns`) is stored by rows, or by columns with a gap after each; both must give the same sums.
template <class Scalar, int kColumns>
void expect_plain_sums(int rows, int columns, double tolerance) {
  using Math = Products<Scalar, kColumns>;
  const int stride = rows + 3;
  const auto w = drawn<Scalar>(rows * columns, 1), bias = drawn<Scalar>(rows, 2);
  const auto in = drawn<Scalar>(columns * Math::kStride, 3);
  AlignedVector<Scalar> by_columns(static_cast<std::size_t>(stride * columns));
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c)
      by_columns[static_cast<std::size_t>(c * stride + r)] = w[static_cast<std::size_t>(r * columns + c)];
  AlignedVector<Scalar> one(static_cast<std::size_t>(rows * Math::kStride)), other(one);
  const auto to = [](AlignedVector<Scalar>& out) {
    return [at = out.data()](int row, int s, auto v) { simd::store(at + row * Math::kStride + s, v); };
  };
  Math::product(w.data(), rows, columns, bias.data(), in.data(), to(one));
  Math::product_by_columns(by_columns.data(), stride, rows, columns, bias.data(), in.data(), to(other));
  EXPECT_EQ(one, other) << rows << " x " << columns << ": each sum adds the columns in order";
  for (int r = 0; r < rows; ++r)
    for (int s = 0; s < kColumns; ++s) {
      double sum = static_cast<double>(bias[static_cast<std::size_t>(r)]);
      for (int c = 0; c < columns; ++c)
        sum += static_cast<double>(w[static_cast<std::size_t>(r * columns + c)]) *
               static_cast<double>(in[static_cast<std::size_t>(c * Math::kStride + s)]);
      ASSERT_NEAR(static_cast<double>(other[static_cast<std::size_t>(r * Math::kStride + s)]), sum, tolerance)
          << rows << " x " << columns << ", row " << r << ", sample " << s;
    }
}

/// Sums of at most 41 products below 1: 41 roundings of at most 41 / 2^24 each.
TEST(BlockProducts, ByRowsAndByColumnsEqualPlainSums) {
  for (const int rows : {1, 2, 7, 12, 13, 15, 16, 17, 31, 32, 33, 50, 64, 96})
    for (const int columns : {1, 3, 34, 40}) {
      expect_plain_sums<float, 8>(rows, columns, 41.0 * 41.0 / (1 << 24));
      expect_plain_sums<float, kBlock>(rows, columns, 41.0 * 41.0 / (1 << 24));
      expect_plain_sums<double, 8>(rows, columns, 1e-12);
    }
}

}  // namespace
}  // namespace nlo::trainer
