// SPDX-License-Identifier: MIT
#include "trainer/gradients/nn/lane_sums.h"

#include <gtest/gtest.h>

namespace nlo::trainer {
namespace {

/// Integers, so that sums are exact in any order; each lane of each register has a different value.
template <class Scalar, int kLanes>
void expect_each_registers_sum_in_its_own_lane() {
  using P = simd::Pack<Scalar, kLanes>;
  P registers[kLanes];
  Scalar expected[kLanes]{};
  for (int i = 0; i < kLanes; ++i) {
    Scalar lanes[kLanes];
    for (int l = 0; l < kLanes; ++l) {
      lanes[l] = static_cast<Scalar>((i + 1) * 1000 + l * l);
      expected[i] += lanes[l];
    }
    registers[i] = simd::load<P>(lanes);
  }
  Scalar sums[kLanes];
  simd::store(sums, lane_sums(registers));
  for (int i = 0; i < kLanes; ++i) EXPECT_EQ(sums[i], expected[i]) << "register " << i << " of " << kLanes;
}

TEST(LaneSums, PutTheSumOfEachRegisterIntoItsLane) {
  expect_each_registers_sum_in_its_own_lane<float, 1>();
  expect_each_registers_sum_in_its_own_lane<float, 4>();
  expect_each_registers_sum_in_its_own_lane<float, 8>();
  expect_each_registers_sum_in_its_own_lane<float, 16>();
  expect_each_registers_sum_in_its_own_lane<double, 2>();
  expect_each_registers_sum_in_its_own_lane<double, 4>();
  expect_each_registers_sum_in_its_own_lane<double, 8>();
}

}  // namespace
}  // namespace nlo::trainer
