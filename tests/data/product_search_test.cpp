// SPDX-License-Identifier: MIT
#include "trainer/data/product_search.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace nlo::trainer {
namespace {

/// Logs of two outputs and an input that wander on their own; x is what `state` makes of them, and a little noise.
Dataset wandering_logs(int logs, const std::function<double(double a, double b, double u)>& state) {
  Dataset data;
  data.outputs = {{"a", "", 0.0}, {"b", "", 0.0}};
  data.inputs = {{"u", "", 0.0}};
  data.states = {{"x", "", 0.0}};
  data.reads_inputs = true;
  data.sample_period_s = 0.1;
  for (int log = 0; log < logs; ++log) {
    Trajectory run;
    constexpr int kSamples = 400;
    run.source = run.log = "log" + std::to_string(log);
    run.time_s = Eigen::VectorXd::LinSpaced(kSamples, 0.0, 0.1 * (kSamples - 1));
    run.outputs.resize(2, kSamples);
    run.inputs.resize(1, kSamples);
    run.states.resize(1, kSamples);
    run.weight = Eigen::VectorXd::Ones(kSamples);
    for (int k = 0; k < kSamples; ++k) {
      const double t = run.time_s[k] + 7.0 * log;
      const double a = 2.0 + std::sin(0.9 * t) + 0.3 * std::cos(2.3 * t), b = std::sin(0.53 * t + 1.0) - 0.4,
                   u = std::cos(1.7 * t);
      run.outputs.col(k) << a, b;
      run.inputs(0, k) = u;
      run.states(0, k) = state(a, b, u) + 0.01 * std::sin(97.0 * t * t);
    }
    data.trajectories.push_back(std::move(run));
  }
  return data;
}

TEST(ProductSearch, FindsTheProductsThatAStateIsMadeOf) {
  const auto found =
      find_products(wandering_logs(4, [](double a, double b, double u) { return a * u + 0.5 * b * b + a; }));
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].expression, "a * u");  // the larger part
  EXPECT_EQ(found[0].name, "a_u");
  EXPECT_EQ(found[1].expression, "b^2");
  EXPECT_EQ(found[1].name, "b_squared");
  EXPECT_GT(found[0].gain, 0.3);
}

TEST(ProductSearch, FindsNoneWhereASumOfChannelsIsAsGood) {
  EXPECT_TRUE(find_products(wandering_logs(4, [](double a, double b, double u) { return a - 2.0 * b + u; })).empty());
}

TEST(ProductSearch, FindsNoneWhereTooFewLogsCouldSaySo) {
  const auto product = [](double a, double, double u) { return a * u; };
  EXPECT_TRUE(find_products(wandering_logs(2, product)).empty());
  EXPECT_FALSE(find_products(wandering_logs(3, product)).empty());  // the control
}

TEST(ProductSearch, TakesNoPartOfAnAngleThatWrapsOrOfWhatIsComputed) {
  Dataset data = wandering_logs(4, [](double a, double, double u) { return a * u; });
  data.outputs[0].wrap = 6.28;
  EXPECT_TRUE(find_products(data).empty() || find_products(data)[0].expression.find('a') == std::string::npos);
  data.outputs[0] = {"a", "", 0.0};
  data.outputs[1] = {"b", "", 0.0, "a^2"};
  for (const FoundProduct& product : find_products(data)) EXPECT_EQ(product.expression.find('b'), std::string::npos);
}

}  // namespace
}  // namespace nlo::trainer
