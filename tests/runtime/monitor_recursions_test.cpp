// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "nlo/monitor.h"
#include "tests/runtime/watched_fakes.h"

namespace nlo::monitor_tests {
namespace {

/// The recursions of nlo/monitor.h, written as in the comment at its top.
struct Recursions {
  static constexpr double kMost = kLargestInnovation;
  const Wide::Model& m;
  double mean[2][3]{}, power[2][3]{}, variance[2][3]{{1, 1, 1}, {1, 1, 1}}, correlation[2][3]{};
  double distance[3] = {1, 1, 1}, share[2]{}, last[2]{}, predicted[2]{}, y[2]{}, disagreement[2]{}, place = 0.0;
  int rejected[2]{}, samples = 0;
  bool missing[2]{};
  double level = 0.0;
  Alarm alarm = Alarm::kNone;

  double innovation(int j, double reading) const {
    const double change = j == 0 ? std::remainder(reading - y[j], 0.75) : reading - y[j];
    return (change * m.per_deviation[j] - predicted[j]) / (1.0 + m.motion[j] * place);
  }
  void gate(const Vector<double, 2>& given) {
    for (int j = 0; j < 2; ++j) {
      missing[j] = std::isnan(given[j]);
      if (missing[j] || samples <= m.armed_after) continue;
      const double e = innovation(j, given[j]);
      const bool beyond = e * e > m.gate_squared * std::max(1.0, variance[j][0]);
      missing[j] = beyond && rejected[j] < kMostRejected;
      rejected[j] = beyond ? std::min(rejected[j] + 1, kMostRejected) : 0;
    }
  }
  void ask(double value, double limit, Alarm kind) {
    if (value / limit <= level) return;
    level = value / limit;
    alarm = kind;
  }
  void watch(const Wide& observer, const Vector<double, 2>& x_hat) {
    double square = 0.0, size = 0.0;
    for (int r = 0; r < 3; ++r) {
      const double off = (observer.z[r] - m.latent_mean[r]) * m.per_latent_deviation[r];
      square += off * off;
      size += std::abs(off);
    }
    for (int w = 0; w < 3; ++w) distance[w] += m.gain[w] * (std::min(square / 3.0, kMost * kMost) - distance[w]);
    for (int j = 0; j < 2; ++j) {
      if (samples > 0 && !missing[j]) {
        const double e = std::clamp(innovation(j, observer.y[j]), -kMost, kMost);
        for (int w = 0; w < 3; ++w) {
          mean[j][w] += m.gain[w] * (e - mean[j][w]);
          power[j][w] += m.gain[2] * (mean[j][w] * mean[j][w] - power[j][w]);
          variance[j][w] += m.gain[w] * (e * e - variance[j][w]);
          correlation[j][w] += m.gain[w] * (e * last[j] - correlation[j][w]);
        }
        last[j] = e;
      }
      share[j] += m.gain[0] * ((missing[j] ? 1.0 : 0.0) - share[j]);
      predicted[j] = m.offset[j];
      for (int i = 0; i < 3; ++i)
        predicted[j] += m.prediction[j][i] * observer.z[i] + m.prediction[j][3 + i] * observer.y[i];
      for (int i = 0; i < 2; ++i) predicted[j] += m.prediction[j][6 + i] * x_hat[i];
      y[j] = observer.y[j];
    }
    place = std::min(size / 3.0, kMost);
    for (int i = 0; i < 2; ++i) {
      double off = x_hat[i] * m.per_row_deviation[i] - m.row_offset[i];
      for (int r = 0; r < 3; ++r) off -= m.row[i][r] * observer.z[r] + m.row[i][3 + r] * observer.y[r];
      disagreement[i] += m.gain[1] * (std::min(std::abs(off), kMost * kMost) - disagreement[i]);
    }
    samples = std::min(samples + 1, m.armed_after + 1);
    level = 0.0;
    for (int w = 0; w < 3; ++w) {
      ask(distance[w], m.latent_limit[w], Alarm::kLatentDistance);
      for (int j = 0; j < 2; ++j) {
        const double noise = std::max(variance[j][w], m.least_variance[j]);
        ask(power[j][w] / noise, m.mean_limit[j][w], Alarm::kInnovationMean);
        ask(variance[j][w], m.variance_limit[j][w], Alarm::kInnovationVariance);
        ask(std::abs(correlation[j][w]), m.correlation_limit[j][w], Alarm::kInnovationCorrelation);
        ask(share[j], m.missing_limit[j], Alarm::kMissing);
      }
    }
    for (int i = 0; i < 2; ++i) ask(disagreement[i], m.disagreement_limit[i], Alarm::kDisagreement);
    const bool missed = share[0] > m.missing_limit[0] || share[1] > m.missing_limit[1];
    if (samples <= m.armed_after) alarm = missed ? Alarm::kMissing : Alarm::kNone;
    if (!(level > 1.0)) alarm = Alarm::kNone;
  }
};

TEST(Monitor, EveryStatisticEqualsItsRecursionInEachOutputAndWindow) {
  std::mt19937 engine(5);
  const auto within = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  };
  Wide::Model m{};
  for (int w = 0; w < 3; ++w) m.gain[w] = std::pow(0.3, w + 1);
  for (int j = 0; j < 2; ++j) {
    for (double& weight : m.prediction[j]) weight = within(-0.2, 0.2);
    m.offset[j] = within(-0.2, 0.2);
    m.per_deviation[j] = 20.0 + 5.0 * j;  // e = 7.5 is half a turn
    m.least_variance[j] = 0.5 + 0.2 * j;
    m.motion[j] = 0.1 + 0.1 * j;
    m.missing_limit[j] = 0.7 + 0.1 * j;
    for (int w = 0; w < 3; ++w) {
      m.mean_limit[j][w] = within(0.5, 0.7);
      m.variance_limit[j][w] = within(5.0, 7.0);
      m.correlation_limit[j][w] = within(0.9, 1.2);
      m.latent_limit[w] = within(3.0, 4.0);
    }
  }
  for (int i = 0; i < 2; ++i) {
    for (double& weight : m.row[i]) weight = within(-0.5, 0.5);
    m.row_offset[i] = within(-0.2, 0.2);
    m.per_row_deviation[i] = 1.0 + i;
    m.disagreement_limit[i] = within(2.0, 2.5);
  }
  m.prediction[1][4] = -5.0;  // back to 0: the predicted change stays within half a turn
  for (int r = 0; r < 3; ++r) {
    m.latent_mean[r] = within(-1.0, 1.0);
    m.per_latent_deviation[r] = within(1.0, 3.0);
  }
  m.gate_squared = 16.0;
  m.armed_after = 20;

  enum { kCalm, kBias, kNoise, kAlternating, kFarAway, kMissing, kJump, kExtrapolates, kKinds };
  Monitor<Wide::Model> monitor(m);
  Recursions want{m};
  Wide observer;
  int alarms[8] = {};
  for (int k = 0; k < 300 * kKinds; ++k) {
    const int j_wrong = k / (150 * kKinds), kind = k / 150 % kKinds;  // first in one output, then in the other
    Vector<double, 2> y{}, x_hat{{within(-1.0, 1.0), within(-1.0, 1.0)}};
    for (int j = 0; j < 2; ++j) {
      double e = within(-1.0, 1.0);
      if (j == j_wrong && kind == kBias) e += 1.5;
      if (j == j_wrong && kind == kNoise) e *= 5.5;
      if (j == j_wrong && kind == kAlternating) e = k % 2 == 0 ? 1.6 : -1.6;
      if (j == j_wrong && kind == kJump && k % 150 < 40) e = 6.5;
      y[j] = want.y[j] + (want.predicted[j] + e * (1.0 + m.motion[j] * want.place)) / m.per_deviation[j];
      if (j == j_wrong && kind == kMissing && k % 20 != 0) y[j] = std::numeric_limits<double>::quiet_NaN();
    }
    if (kind == kExtrapolates) x_hat[j_wrong] += 5.0;
    const auto kept = monitor.usable_outputs(y, observer);
    want.gate(y);
    for (int j = 0; j < 2; ++j) {
      ASSERT_EQ(std::isnan(kept[j]), want.missing[j]) << k;
      if (!std::isnan(kept[j])) observer.y[j] = j == 0 ? std::remainder(kept[j], 0.75) : kept[j];
    }
    observer.y[2] = within(0.0, 1.0);
    for (int r = 0; r < 3; ++r)
      observer.z[r] = m.latent_mean[r] + within(-1.0, 1.0) * (kind == kFarAway ? 5.0 : 1.0) / m.per_latent_deviation[r];
    ASSERT_EQ(monitor.watch(observer, x_hat), (want.watch(observer, x_hat), want.alarm)) << k;
    ++alarms[static_cast<int>(want.alarm)];

    constexpr double kRounding = 1e-10;
    const auto got = monitor.save();
    ASSERT_NEAR(got.level, want.level, kRounding) << k;
    ASSERT_EQ(got.samples, want.samples);
    for (int i = 0; i < 2; ++i) ASSERT_NEAR(got.disagreement[i], want.disagreement[i], kRounding) << k;
    for (int w = 0; w < 3; ++w) ASSERT_NEAR(got.distance[w], want.distance[w], kRounding) << k;
    for (int j = 0; j < 2; ++j) {
      const auto& own = got.outputs[j];
      ASSERT_NEAR(own.predicted, want.predicted[j], kRounding) << k;
      ASSERT_NEAR(own.last, want.last[j], kRounding) << k;
      ASSERT_NEAR(own.missing_share, want.share[j], kRounding) << k;
      ASSERT_EQ(own.rejected, want.rejected[j]) << k;
      for (int w = 0; w < 3; ++w) {
        ASSERT_NEAR(own.windows[w].mean, want.mean[j][w], kRounding) << k;
        ASSERT_NEAR(own.windows[w].power, want.power[j][w], kRounding) << k;
        ASSERT_NEAR(own.windows[w].variance, want.variance[j][w], kRounding) << k;
        ASSERT_NEAR(own.windows[w].correlation, want.correlation[j][w], kRounding) << k;
      }
    }
  }
  for (int kind = 0; kind <= static_cast<int>(Alarm::kDisagreement); ++kind)
    EXPECT_GT(alarms[kind], 0) << "control: " << kind;
}

}  // namespace
}  // namespace nlo::monitor_tests
