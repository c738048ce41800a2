// SPDX-License-Identifier: MIT
#include "trainer/data/zero_phase_filter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "tests/data/data_testing.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using ::testing::HasSubstr;

constexpr double kRate_hz = 250.0;
constexpr double kFilterRounding = 1e-9;  // rounding of a recursion over some hundred samples of size one
constexpr Index kSettled =
    200;  // samples after which the transient of an end is below rounding, for a cut-off of 25 Hz at 250 Hz

double gain_at(const std::vector<FilterSection>& sections, double frequency_hz) {
  const std::complex<double> delay = std::polar(1.0, -kTurn * frequency_hz / kRate_hz);
  std::complex<double> gain = 1.0;
  for (const FilterSection& s : sections)
    gain *= (s.b0 + delay * (s.b1 + delay * s.b2)) / (1.0 + delay * (s.a1 + delay * s.a2));
  return std::abs(gain);
}

VectorXd sine(double frequency_hz, Index samples) {
  return (VectorXd::LinSpaced(samples, 0.0, static_cast<double>(samples - 1)).array() *
          (kTurn * frequency_hz / kRate_hz))
      .sin();
}

VectorXd middle(const VectorXd& x) {
  return x.segment(kSettled, x.size() - 2 * kSettled);
}

TEST(Butterworth, HasTheGainOfItsClosedFormAtEveryOrder) {
  for (int order = 1; order <= 8; ++order)
    for (const double cutoff_hz : {2.0, 25.0, 110.0}) {
      const auto sections = butterworth_lowpass(order, cutoff_hz, kRate_hz);
      for (const double f : {0.0, 1.0, 10.0, 25.0, 60.0, 120.0}) {
        // |H|^2 = 1 / (1 + (tan(pi f/fs) / tan(pi fc/fs))^2n): the analogue filter on the bilinear transform's axis.
        const double ratio =
            std::tan(std::numbers::pi * f / kRate_hz) / std::tan(std::numbers::pi * cutoff_hz / kRate_hz);
        EXPECT_NEAR(gain_at(sections, f), 1.0 / std::sqrt(1.0 + std::pow(ratio, 2 * order)), kFilterRounding)
            << "order " << order << ", cut-off " << cutoff_hz << " Hz, at " << f << " Hz";
      }
      EXPECT_NEAR(gain_at(sections, cutoff_hz), std::sqrt(0.5), kFilterRounding);
    }
}

TEST(Butterworth, RefusesImpossibleSettings) {
  EXPECT_THAT(thrown_message([] { butterworth_lowpass(0, 25.0, kRate_hz); }), HasSubstr("order = 0: expected 1 to 8"));
  EXPECT_THAT(thrown_message([] { butterworth_lowpass(9, 25.0, kRate_hz); }), HasSubstr("order = 9"));
  for (const double cutoff_hz : {0.0, -1.0, 125.0, 300.0, std::nan("")})
    EXPECT_THAT(thrown_message([&] { butterworth_lowpass(4, cutoff_hz, kRate_hz); }),
                HasSubstr("less than half the sample rate, 125 Hz"));
}

TEST(ZeroPhaseFilter, KeepsAConstant) {
  for (int order = 1; order <= 8; ++order) {
    const VectorXd constant = VectorXd::Constant(100, 3.5);
    EXPECT_LT(
        (filter_zero_phase(butterworth_lowpass(order, 25.0, kRate_hz), constant) - constant).cwiseAbs().maxCoeff(),
        kFilterRounding);
  }
}

// Two passes multiply by |H|^2, which differs from 1 by the power 2n of the frequency, so lower moments are kept.
TEST(ZeroPhaseFilter, PreservesCubicsInTheMiddle) {
  const VectorXd t = VectorXd::LinSpaced(1000, -1.0, 1.0);
  const VectorXd cubic = 1.0 - 2.0 * t.array() + 0.5 * t.array().square() + t.array().cube();
  const VectorXd filtered = filter_zero_phase(butterworth_lowpass(4, 25.0, kRate_hz), cubic);
  EXPECT_LT((middle(filtered) - middle(cubic)).cwiseAbs().maxCoeff(), kFilterRounding);
}

// The odd extension continues the slope; only the start of the extension remains as an error. An even extension folds
// the ramp back, which is wrong by the step of a whole sample.
TEST(ZeroPhaseFilter, KeepsARampUpToTheEnds) {
  const VectorXd ramp = VectorXd::LinSpaced(300, 0.0, 299.0);
  const VectorXd filtered = filter_zero_phase(butterworth_lowpass(4, 25.0, kRate_hz), ramp);
  EXPECT_LT((filtered - ramp).cwiseAbs().maxCoeff(), 0.05);
}

TEST(ZeroPhaseFilter, PassesASineWithTheSquaredGainAndNoDelay) {
  const auto sections = butterworth_lowpass(4, 25.0, kRate_hz);
  for (const double f : {1.0, 5.0, 25.0, 40.0}) {
    const VectorXd x = sine(f, 2000);
    const VectorXd expected = gain_at(sections, f) * gain_at(sections, f) * x;
    EXPECT_LT((middle(filter_zero_phase(sections, x)) - middle(expected)).cwiseAbs().maxCoeff(), kFilterRounding)
        << f << " Hz";
  }
}

TEST(ZeroPhaseFilter, GivesTheSameResultForReversedTime) {
  VectorXd x = sine(3.0, 1200) + sine(11.0, 1200).cwiseAbs2();
  const auto sections = butterworth_lowpass(5, 25.0, kRate_hz);
  const VectorXd forwards = filter_zero_phase(sections, x);
  x.reverseInPlace();
  const VectorXd backwards = filter_zero_phase(sections, x).reverse();
  EXPECT_LT((middle(forwards) - middle(backwards)).cwiseAbs().maxCoeff(), kFilterRounding);
}

TEST(ZeroPhaseFilter, RefusesALogShorterThanItsExtension) {
  const auto sections = butterworth_lowpass(4, 25.0, kRate_hz);
  EXPECT_THAT(thrown_message([&] { filter_zero_phase(sections, VectorXd::Zero(15)); }),
              HasSubstr("15 samples are too few"));
  EXPECT_EQ(thrown_message([&] { filter_zero_phase(sections, VectorXd::Zero(16)); }), "no error");
}

TEST(CentralDifference, IsExactForParabolas) {
  const double h = 0.01;
  const VectorXd t = VectorXd::LinSpaced(50, 0.0, 0.49);
  const VectorXd slope = central_difference(1.0 + 2.0 * t.array() - 3.0 * t.array().square(), h);
  const VectorXd expected = 2.0 - 6.0 * t.array();
  EXPECT_LT((slope - expected).segment(1, 48).cwiseAbs().maxCoeff(), kFilterRounding);
  EXPECT_NEAR(slope[0], expected[0], 4.0 * h);  // one-sided: first order
}

TEST(Interpolate, IsExactOnLinesAndHoldsTheEnds) {
  const VectorXd time = Eigen::Vector4d(0.0, 1.0, 1.5, 4.0), at = Eigen::Vector4d(-1.0, 0.25, 3.0, 9.0);
  const VectorXd values = interpolate(time, 2.0 * time, at);
  EXPECT_LT((values - Eigen::Vector4d(0.0, 0.5, 6.0, 8.0)).cwiseAbs().maxCoeff(), kFilterRounding);
  EXPECT_EQ(interpolate(time, 2.0 * time, time), VectorXd(2.0 * time));
}

TEST(ZeroPhaseVelocity, DifferentiatesOnAClockThatJitters) {
  const SyntheticLog log;
  VectorXd time(log.samples), position(log.samples), truth(log.samples);
  for (int k = 0; k < log.samples; ++k) {
    time[k] = log.time_s(k) - log.time_s(0);
    position[k] = SyntheticLog::angle(log.time_s(k));
    truth[k] = SyntheticLog::velocity(log.time_s(k));
  }
  VelocityFilterConfig config;
  config.cutoff_hz = 20.0;
  const VectorXd velocity = zero_phase_velocity(config, time, position, log.period_s);
  const auto worst = [&](const VectorXd& v) {
    return (v - truth).segment(100, log.samples - 200).cwiseAbs().maxCoeff();
  };
  // Linear interpolation costs h^2/8 of the second derivatives: 16 h^2/8 = 5e-5 in velocity, and 8 h^2/8 in position
  // over a step of jitter; the central difference costs 16 h^2/6 = 7e-5.
  EXPECT_LT(worst(velocity), 1e-3);
  // Control: treating the same samples as evenly spaced is at least ten times worse.
  const VectorXd even = VectorXd::LinSpaced(log.samples, 0.0, time[log.samples - 1]);
  EXPECT_GT(worst(central_difference(position, even[1])), 1e-2);
}

}  // namespace
}  // namespace nlo::trainer
