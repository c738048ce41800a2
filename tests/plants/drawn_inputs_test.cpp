// SPDX-License-Identifier: MIT
#include "trainer/plants/drawn_inputs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <numbers>
#include <set>

#include "trainer/plants/run_random.h"
#include "trainer/plants/simulate.h"

namespace nlo::trainer {
namespace {

constexpr double kSamplePeriod = 0.02;
constexpr std::uint64_t kEngineSeed = 20261123;
constexpr std::uint64_t kRuns = 40;

SimulationConfig sampled() {
  SimulationConfig config;
  config.sample_period_s = kSamplePeriod;
  config.horizon_s = 40.0;
  return config;
}

/// One input with the range -1 .. 3, whose middle is 1.
ExcitationConfig of_kind(InputSignal kind) {
  ExcitationConfig config;
  config.kinds = {kind};
  config.low = {-1.0};
  config.high = {3.0};
  config.amplitude = {0.5, 2.0};
  config.shortest_s = 0.4;
  config.longest_s = 8.0;
  return config;
}

/// A log of one minute, for the kind "log".
LoggedInputs recorded() {
  LoggedInputs log;
  log.time_s = Eigen::VectorXd::LinSpaced(601, 0.0, 60.0);
  log.values = 1.0 + 1.5 * (0.7 * log.time_s.transpose().array()).sin();
  return log;
}

Eigen::RowVectorXd drawn(const ExcitationConfig& config, std::uint64_t run, std::uint64_t seed = kEngineSeed) {
  return draw_inputs(config, sampled(), seed, run, recorded()).row(0);
}

/// Returns the numbers of samples between changes of the value.
std::vector<int> holds(const Eigen::RowVectorXd& u) {
  std::vector<int> result;
  int since = -1;  // the hold before the first change has an unknown start
  for (Eigen::Index k = 1; k < u.size(); ++k) {
    if (since >= 0) ++since;
    if (u(k) == u(k - 1)) continue;
    if (since > 0) result.push_back(since);
    since = 0;
  }
  return result;
}

std::set<double> levels(const Eigen::RowVectorXd& u) {
  return {u.begin(), u.end()};
}

class EveryKind : public testing::TestWithParam<std::string> {
 protected:
  static ExcitationConfig config() { return of_kind(from_name<InputSignal>(GetParam()).value()); }
};

TEST_P(EveryKind, StaysWithinItsRangeAtEverySample) {
  for (const bool derived : {false, true}) {  // given amplitudes and times, and derived ones
    ExcitationConfig excitation = config();
    if (derived) excitation.amplitude.clear(), excitation.shortest_s = excitation.longest_s = 0.0;
    for (std::uint64_t run = 0; run < kRuns; ++run) {
      const Eigen::RowVectorXd u = drawn(excitation, run);
      ASSERT_EQ(u.size(), sample_count(sampled()));
      EXPECT_GE(u.minCoeff(), -1.0) << run;
      EXPECT_LE(u.maxCoeff(), 3.0) << run;
    }
  }
}

TEST_P(EveryKind, IsReproducibleAndDiffersBetweenRuns) {
  EXPECT_EQ(drawn(config(), 7), drawn(config(), 7));
  if (GetParam() == "zero") return;
  EXPECT_NE(drawn(config(), 7), drawn(config(), 8));
  EXPECT_NE(drawn(config(), 7), drawn(config(), 7, kEngineSeed + 1));
}

TEST_P(EveryKind, MovesUnlessItIsConstant) {
  const bool still = GetParam() == "zero" || GetParam() == "constant";
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    const Eigen::RowVectorXd u = drawn(config(), run);
    EXPECT_EQ(levels(u).size() == 1, still) << run;
  }
}

std::string name_of(const testing::TestParamInfo<std::string>& info) {
  return info.param;
}

INSTANTIATE_TEST_SUITE_P(Signals, EveryKind, testing::ValuesIn(all_names<InputSignal>()), name_of);

TEST(DrawnInputs, RefusesTheKindLogWithoutALog) {
  EXPECT_ANY_THROW(draw_inputs(of_kind(InputSignal::kLog), sampled(), kEngineSeed, 0));
}

TEST(DrawnInputs, StepsAreHeldBetweenTheShortestAndTheLongestTime) {
  int found = 0;
  for (std::uint64_t run = 0; run < kRuns; ++run)
    for (const int hold : holds(drawn(of_kind(InputSignal::kSteps), run))) {
      ++found;
      EXPECT_GE(hold, 19) << "0.4 s are 20 samples, or 19 if it begins and ends between samples";
      EXPECT_LE(hold, 401);
    }
  EXPECT_GT(found, 100);
}

TEST(DrawnInputs, RandomBinarySequenceHasTwoLevelsAndOneClock) {
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    const Eigen::RowVectorXd u = drawn(of_kind(InputSignal::kPrbs), run);
    EXPECT_EQ(levels(u).size(), 2u);
    const std::vector<int> all = holds(u);
    if (all.size() < 20) continue;  // a slow clock gives too few holds
    const int clock = *std::min_element(all.begin(), all.end());
    for (const int hold : all) {
      const double cycles = std::round(hold / static_cast<double>(clock));
      EXPECT_NEAR(hold, cycles * clock, 1.0 + cycles) << "each change may be one sample late";
    }
  }
}

TEST(DrawnInputs, SineSatisfiesTheRecursionOfAnOscillator) {
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    const Eigen::ArrayXd s = drawn(of_kind(InputSignal::kSine), run).transpose().array() - 1.0;
    const Eigen::Index n = s.size() - 2;
    const Eigen::ArrayXd inner = s.segment(1, n), outer = s.head(n) + s.tail(n);
    const double two_cos = (inner * outer).sum() / inner.square().sum();
    EXPECT_LE((outer - two_cos * inner).abs().maxCoeff(), 1e-11) << "rounding of t / T is 1e-14 turns, times 2 pi A";
    const double cycle = 2.0 * std::numbers::pi * kSamplePeriod / std::acos(0.5 * two_cos);
    EXPECT_GE(cycle, 0.4 * (1 - 1e-6));
    EXPECT_LE(cycle, 8.0 * (1 + 1e-6));
    EXPECT_GE(s.abs().maxCoeff(), 0.5 * std::cos(std::numbers::pi * kSamplePeriod / 0.4))
        << "a peak between two samples";
    EXPECT_LE(s.abs().maxCoeff(), 2.0);
  }
}

TEST(DrawnInputs, SquareHasTwoLevelsAboutTheMiddle) {
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    const Eigen::RowVectorXd u = drawn(of_kind(InputSignal::kSquare), run);
    const double size = u.maxCoeff() - 1.0;
    EXPECT_GE(size, 0.5);
    EXPECT_NEAR(u.minCoeff(), 1.0 - size, 1e-15);
    EXPECT_EQ(levels(u).size(), 2u);
  }
}

TEST(DrawnInputs, ChirpGoesFromOnePeriodToAnother) {
  int faster = 0;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    const Eigen::RowVectorXd u = drawn(of_kind(InputSignal::kChirp), run);
    std::vector<double> crossings;
    for (Eigen::Index k = 1; k < u.size(); ++k)
      if (u(k - 1) < 1.0 && u(k) >= 1.0) crossings.push_back(static_cast<double>(k) * kSamplePeriod);
    ASSERT_GE(crossings.size(), 4u);
    for (std::size_t i = 1; i < crossings.size(); ++i) {
      EXPECT_GE(crossings[i] - crossings[i - 1], 0.4 - kSamplePeriod);
      EXPECT_LE(crossings[i] - crossings[i - 1], 8.0 + kSamplePeriod);
    }
    const double begin = crossings[1] - crossings[0], end = crossings.back() - crossings[crossings.size() - 2];
    faster += begin > end + 2.0 * kSamplePeriod ? 1 : 0;
  }
  EXPECT_GT(faster, 5) << "some chirps become faster";
  EXPECT_LT(faster, 35) << "and some become slower";
}

TEST(DrawnInputs, NoiseHasTheGivenCutOffAndDeviation) {
  ExcitationConfig config = of_kind(InputSignal::kNoise);
  config.shortest_s = config.longest_s = 0.5;
  double sum = 0.0, square = 0.0, product = 0.0, count = 0.0;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    const Eigen::ArrayXd s = drawn(config, run).transpose().array() - 1.0;
    sum += s.sum();
    square += s.square().sum();
    product += (s.head(s.size() - 1) * s.tail(s.size() - 1)).sum();
    count += static_cast<double>(s.size());
  }
  // A cut-off of 2 Hz has a memory of 0.08 s, so 80,000 samples are about 10,000 draws with a standard error of 1 %.
  // The deviation is half of the half range, which is 2, minus about 4 % for the reflection at two deviations.
  EXPECT_NEAR(sum / count, 0.0, 0.04);
  EXPECT_NEAR(std::sqrt(square / count), 0.96, 0.04);
  EXPECT_NEAR(product / square, std::exp(-2.0 * std::numbers::pi * kSamplePeriod / 0.5), 0.02);
}

TEST(DrawnInputs, EachInputHasItsOwnRangeKindAndRandomStream) {
  ExcitationConfig config = of_kind(InputSignal::kSteps);
  config.low = {-1.0, 10.0};
  config.high = {3.0, 14.0};
  const Eigen::MatrixXd u = draw_inputs(config, sampled(), kEngineSeed, 3);
  ASSERT_EQ(u.rows(), 2);
  EXPECT_GE(u.row(1).minCoeff(), 10.0);
  EXPECT_GT((u.row(1).array() - 11.0 - u.row(0).array()).abs().maxCoeff(), 0.1);
  EXPECT_EQ(u.row(0), drawn(of_kind(InputSignal::kSteps), 3)) << "it does not depend on other inputs";

  config.kinds = {InputSignal::kConstant, InputSignal::kSteps};
  std::set<bool> still;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    const Eigen::MatrixXd of_run = draw_inputs(config, sampled(), kEngineSeed, run);
    still.insert((levels(of_run.row(0)).size() == 1) == (levels(of_run.row(1)).size() == 1));
  }
  EXPECT_EQ(still.size(), 2u) << "both inputs have the same kind in some runs and different kinds in others";
}

TEST(DrawnInputs, DefaultTimesComeFromTheSamplePeriodAndTheHorizon) {
  ExcitationConfig config;
  EXPECT_EQ(hold_times(config, sampled()).shortest_s, 10.0 * kSamplePeriod);
  EXPECT_EQ(hold_times(config, sampled()).longest_s, 20.0);
  config.longest_s = 0.1;
  EXPECT_EQ(hold_times(config, sampled()).shortest_s, 0.1);
  config = {};
  config.shortest_s = 30.0;
  EXPECT_EQ(hold_times(config, sampled()).longest_s, 30.0);
}

/// Fowler, Noll and Vo's hash (FNV-1a) of the bits.
std::uint64_t hash_of(const Eigen::RowVectorXd& u) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const double value : u)
    for (int byte = 0; byte < 8; ++byte)
      hash = (hash ^ ((std::bit_cast<std::uint64_t>(value) >> (8 * byte)) & 0xff)) * 0x100000001b3ULL;
  return hash;
}

// These hashes were recorded once: each compiler, library and processor must draw the same bits.
TEST(DrawnInputs, AreTheSameBitsOnEveryMachine) {
  const std::vector<std::pair<InputSignal, std::uint64_t>> recorded = {
      {InputSignal::kConstant, 11519577038721210741ULL}, {InputSignal::kSteps, 3124791327631828900ULL},
      {InputSignal::kPrbs, 9672127182821504149ULL},      {InputSignal::kSine, 1277924652411696633ULL},
      {InputSignal::kSquare, 6179474416693328144ULL},    {InputSignal::kMultisine, 12583372521426327876ULL},
      {InputSignal::kChirp, 7821723406327281875ULL},     {InputSignal::kNoise, 1078539855811815388ULL}};
  for (const auto& [kind, hash] : recorded) EXPECT_EQ(hash_of(drawn(of_kind(kind), 1)), hash) << to_name(kind);
}

TEST(RunRandom, FunctionsEqualThoseOfTheLibraryToRounding) {
  RunRandom random(1, RunPurpose::kInputs, 0, 0);
  for (int i = 0; i < 20000; ++i) {
    const double x = random.log_between(1e-9, 1e9), exponent = random.between(-40.0, 40.0),
                 t = random.between(-9.0, 9.0);
    EXPECT_NEAR(portable_log(x), std::log(x), 4e-16 * (1.0 + std::abs(std::log(x)))) << x;
    EXPECT_NEAR(portable_exp(exponent) / std::exp(exponent), 1.0, 1e-15) << exponent;
    // The argument 2 pi t of the library loses the bits of 9 turns: 2 pi 9 epsilon / 2.
    EXPECT_NEAR(sine_of_turns(t), std::sin(2.0 * std::numbers::pi * t), 2e-14) << t;
  }
  for (const double eighth : {0.0, 0.25, 0.5, 0.75, 1.0, -0.25, 7.5})
    EXPECT_NEAR(sine_of_turns(eighth), std::round(std::sin(2.0 * std::numbers::pi * eighth)), 1e-16) << eighth;
}

TEST(RunRandom, DrawsFromTheDistributionsItNames) {
  RunRandom random(2, RunPurpose::kProcessNoise, 0, 0);
  constexpr int kDraws = 40000;  // standard errors of 0.5 %, and of 0.7 % for a variance
  double sum = 0.0, square = 0.0, below = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double n = random.normal();
    sum += n;
    square += n * n;
    below += random.log_between(0.01, 100.0) < 1.0 ? 1.0 : 0.0;
  }
  EXPECT_NEAR(sum / kDraws, 0.0, 0.02);
  EXPECT_NEAR(square / kDraws, 1.0, 0.03);
  EXPECT_NEAR(below / kDraws, 0.5, 0.01);
  EXPECT_EQ(random.log_between(0.3, 0.3), 0.3);
  EXPECT_EQ(random.between(-2.0, -2.0), -2.0);
}

}  // namespace
}  // namespace nlo::trainer
