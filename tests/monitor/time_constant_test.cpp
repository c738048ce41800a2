// SPDX-License-Identifier: MIT
#include "trainer/monitor/time_constant.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/codegen/example_models.h"

namespace nlo::trainer {
namespace {

TEST(TimeConstant, OfALinearLatentSystemIsThatOfItsSlowestModeButClocks) {
  // rig_model: pairs at -40 and -25, real -60 and -15 [1/s]; the clock at -2 reads no output.
  EXPECT_DOUBLE_EQ(time_constant_s(codegen::rig_model(), {}), 1.0 / 15.0);
}

TEST(TimeConstant, OfOtherStructuresIsThePeriodOfTheOutputs) {
  const codegen::Model model = codegen::gated_model();
  ASSERT_EQ(codegen::linear_latent(model), nullptr);
  const double period_s = 200.0 * model.sample_period_s;
  SensedRuns runs;
  std::mt19937 engine(1);
  std::normal_distribution<double> noise(0.0, 0.5);
  for (int i = 0; i < 4; ++i) {
    Eigen::MatrixXd y(model.ny(), 2000);
    for (Eigen::Index k = 0; k < y.cols(); ++k)
      y.col(k).setConstant(3.0 + std::sin(2.0 * std::numbers::pi * static_cast<double>(k) / 200.0 + i) + noise(engine));
    runs.outputs.push_back(y);
    runs.inputs.emplace_back();
  }
  // The integral of cos from 0 to a quarter is 1 / (2 pi) of the period. Noise is not in lag 1 on; 2,000 samples of a
  // wave of 200 and the sum in place of the integral are good for some percent.
  EXPECT_NEAR(time_constant_s(model, runs), period_s, 0.06 * period_s);
}

}  // namespace
}  // namespace nlo::trainer
