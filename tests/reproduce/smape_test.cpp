// SPDX-License-Identifier: MIT
// SMAPE over components and over vectors, compared with closed forms.
#include "trainer/reproduce/smape.h"

#include <gtest/gtest.h>

#include <cmath>

namespace nlo::trainer {
namespace {

TEST(Smape, AppliesToComponentsOrToVectors) {
  Eigen::MatrixXd truth(2, 2), estimate(2, 2);
  truth << 3.0, 1.0,  //
      4.0, 0.0;
  estimate << 1.0, -1.0,  //
      4.0, 0.0;
  // |3 - 1| / 4, |1 + 1| / 2, 0, and 0/0 counts as 0
  EXPECT_DOUBLE_EQ(smape_of_components(truth, estimate), 200.0 * (0.5 + 1.0) / 4.0);
  const Eigen::Vector2d time_s(0.0, 1.0);
  const double first = 2.0 / (5.0 + std::sqrt(17.0)), second = 2.0 / 2.0;
  EXPECT_DOUBLE_EQ(smape_of_norms(truth, estimate, time_s), 200.0 * (first + second) / 2.0);
  EXPECT_DOUBLE_EQ(smape_of_norms(truth, estimate, time_s, 1.0), 200.0 * second);
}

TEST(Smape, EqualsTheClosedFormForAConstantFactor) {
  const Eigen::MatrixXd truth = Eigen::MatrixXd::Random(3, 50);
  const Eigen::VectorXd time_s = Eigen::VectorXd::LinSpaced(50, 0.0, 4.9);
  const double factor = 1.1, expected = 200.0 * (factor - 1.0) / (factor + 1.0);
  EXPECT_NEAR(smape_of_components(truth, factor * truth), expected, 1e-9);
  EXPECT_NEAR(smape_of_norms(truth, factor * truth, time_s, 2.0), expected, 1e-9);
  EXPECT_EQ(smape_of_components(truth, truth), 0.0);
  EXPECT_NEAR(smape_of_components(truth, -truth), 200.0, 1e-9);
}

TEST(Smape, AWindowKeepsItsFirstSampleDespiteRounding) {
  const Eigen::MatrixXd truth = Eigen::MatrixXd::Constant(1, 2, 1.0), estimate = Eigen::MatrixXd::Zero(1, 2);
  EXPECT_EQ(smape_of_norms(truth, estimate, Eigen::Vector2d(0.0, 4.9999999), 5.0), 200.0);
  EXPECT_TRUE(std::isnan(smape_of_norms(truth, estimate, Eigen::Vector2d(0.0, 1.0), 5.0)));
}

}  // namespace
}  // namespace nlo::trainer
