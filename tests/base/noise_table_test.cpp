// SPDX-License-Identifier: MIT
// Properties of every row of the table of noises.
#include "trainer/base/noise_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "trainer/base/random.h"

namespace nlo::trainer {
namespace {

constexpr int kDraws = 100'000;

class Scalars final : public NoiseNumbers<double> {
 public:
  double uniform() override { return std::uniform_real_distribution<>(-1.0, 1.0)(engine_); }
  double normal() override { return normal_(engine_); }
  void normals(std::span<double> all) override {
    for (double& each : all) each = normal();
  }

 private:
  std::mt19937_64 engine_{3};
  std::normal_distribution<> normal_;
};

class Lanes final : public NoiseNumbers<LaneValue> {
 public:
  LaneValue uniform() override {
    return LaneValue::NullaryExpr([&] { return static_cast<float>(scalars_.uniform()); });
  }
  LaneValue normal() override {
    return LaneValue::NullaryExpr([&] { return static_cast<float>(scalars_.normal()); });
  }
  void normals(std::span<LaneValue> all) override {
    for (LaneValue& each : all) each = normal();
  }

 private:
  Scalars scalars_;
};

/// Integral of the density over |v| < reach, by the midpoint rule.
double mass(const NoiseRow& row, double reach, int shape) {
  constexpr int kPoints = 20'000;
  const double step = 2.0 * reach / kPoints;
  const Eigen::ArrayXd v = Eigen::ArrayXd::LinSpaced(kPoints, -reach + 0.5 * step, reach - 0.5 * step);
  return row.density(v, shape).sum() * step;
}

class EveryNoise : public ::testing::TestWithParam<std::string> {
 protected:
  const NoiseRow& row() const { return *std::ranges::find(noise_table(), GetParam(), &NoiseRow::name); }
  int shape() const { return row().has_shape() ? std::min(5, row().most_shape) : 0; }
};

TEST_P(EveryNoise, IsWrittenAsItIsRead) {
  const std::string text =
      GetParam() + (row().has_scale() ? ":0.5" : "") + (row().has_shape() ? ":" + std::to_string(shape()) : "");
  const NoiseConfig noise = parse_noise(text);
  EXPECT_EQ(noise.of(0).kind, row().kind);
  EXPECT_EQ(format_noise(noise), text);
  EXPECT_EQ(&noise_row(noise.of(0).kind), &row());
  EXPECT_FALSE(row().title(noise.of(0)).empty());
  EXPECT_EQ(noise.of(0).has_tails(), row().tails);
}

/// Half a percent: five standard errors of a share of 1e5 draws, and the soft edge of a box.
TEST_P(EveryNoise, IsDrawnAsItsDensitySaysByOneAndByEight) {
  if (row().density == nullptr) return;
  EXPECT_NEAR(mass(row(), 200.0, shape()), 1.0, 5e-3);
  Scalars one;
  Lanes eight;
  for (const double reach : {0.3, 0.7, 2.0}) {
    int inside = 0, inside_lanes = 0;
    for (int i = 0; i < kDraws; ++i) inside += std::abs(row().draw(one, shape())) < reach;
    for (int i = 0; i < kDraws / kNoiseLanes; ++i)
      inside_lanes += static_cast<int>((row().draw_lanes(eight, shape()).abs() < static_cast<float>(reach)).count());
    EXPECT_NEAR(inside / double{kDraws}, mass(row(), reach, shape()), 8e-3) << reach;
    EXPECT_NEAR(inside_lanes / double{kDraws}, mass(row(), reach, shape()), 8e-3) << reach;
  }
}

TEST_P(EveryNoise, HasTheVarianceAndTheLimitOfItsRow) {
  Scalars one;
  double squares = 0.0, largest = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double v = row().draw(one, row().has_shape() ? row().most_shape : 0);
    squares += v * v;
    largest = std::max(largest, std::abs(v));
  }
  EXPECT_LE(largest, row().largest);
  EXPECT_EQ(row().bounded(), largest <= 1.0) << "of 1e5 draws of an unbounded one, some are beyond its scale";
  if (row().tails) return;  // its variance is nominal
  EXPECT_NEAR(squares / kDraws, row().variance, 0.03 * row().variance) << "five standard errors, and more";
}

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const NoiseRow& row : noise_table()) all.emplace_back(row.name);
  return all;
}
INSTANTIATE_TEST_SUITE_P(Table, EveryNoise, ::testing::ValuesIn(names()), [](const auto& each) { return each.param; });

}  // namespace
}  // namespace nlo::trainer
