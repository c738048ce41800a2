// SPDX-License-Identifier: MIT
#include "trainer/data/static_ridge.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "codegen/base/error.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;

/// x1 = 2 y_k u_k - y_(k-2) + 3; x2: an angle that is that of y, turned by 100 degrees.
Dataset logs_of_a_product() {
  constexpr Index kSamples = 400;
  Dataset logs{
      {{"y", "", 0.0}, {"angle", "deg", 360.0}}, {{"x1", "", 0.0}, {"x2", "deg", 360.0}}, 0.1, true, {Trajectory()}};
  logs.inputs = {{"u", "", 0.0}};
  Trajectory& run = logs.trajectories[0];
  run.time_s = Eigen::VectorXd::LinSpaced(kSamples, 0.0, 0.1 * (kSamples - 1));
  run.weight = Eigen::VectorXd::Ones(kSamples);
  run.outputs.resize(2, kSamples);
  run.states.resize(2, kSamples);
  run.inputs.resize(1, kSamples);
  for (Index k = 0; k < kSamples; ++k) {
    const auto t = static_cast<double>(k);
    run.outputs(0, k) = std::sin(0.7 * t) + 0.3 * std::cos(2.1 * t);
    run.outputs(1, k) = 37.0 * t;
    run.inputs(0, k) = std::cos(1.3 * t);
    run.states(0, k) = 2.0 * run.outputs(0, k) * run.inputs(0, k) - run.outputs(0, std::max<Index>(0, k - 2)) + 3.0;
    run.states(1, k) = std::remainder(run.outputs(1, k) + 100.0, 360.0);
  }
  run.weight[5] = 0.0;
  run.states(0, 5) = std::numeric_limits<double>::quiet_NaN();
  return logs;
}

TEST(StaticRidge, FindsAProductAndAnAngleOfTheLastThreeSamples) {
  const Dataset logs = logs_of_a_product();
  const Trajectory& run = logs.trajectories[0];
  const Eigen::MatrixXd x = StaticRidge::fit(logs).estimate(run);
  const auto worst = [&](const Eigen::MatrixXd& estimate) {
    double largest = 0.0;
    for (Index k = 6; k < run.samples(); ++k) largest = std::max(largest, std::abs(estimate(0, k) - run.states(0, k)));
    return largest;
  };
  EXPECT_LT(worst(x), 1e-3);  // the ridge's own part
  EXPECT_GT(worst(StaticRidge::fit(logs, 2).estimate(run)), 0.05)
      << "control: two samples do not reach back far enough";
  for (Index k = 6; k < run.samples(); ++k)
    ASSERT_LT(std::abs(std::remainder(x(1, k) - run.states(1, k), 360.0)), 0.1) << k;
}

TEST(StaticRidge, NeedsTruth) {
  Dataset logs = logs_of_a_product();
  logs.trajectories[0].weight.setZero();
  EXPECT_THAT([&] { StaticRidge::fit(logs); },
              testing::ThrowsMessage<codegen::Error>(testing::HasSubstr("no sample to fit it on")));
}

}  // namespace
}  // namespace nlo::trainer
