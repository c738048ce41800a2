// SPDX-License-Identifier: MIT
#include "trainer/recipe/mode_banks.h"

#include <gtest/gtest.h>

namespace nlo::trainer {
namespace {

constexpr double kRounding = 0.01;  // banks are told to three digits

TEST(ModeBanks, ForgetWithinARunAndKeepBelowTheSampleRate) {
  for (const double period_s : {1e-4, 0.02, 1.0})
    for (const double samples : {200.0, 2500.0, 20000.0}) {
      const auto banks = mode_banks(period_s, samples * period_s, 100);
      ASSERT_GE(banks.size(), 10U);
      for (const ModeBank& bank : banks) {
        EXPECT_GE(bank.slowest() * samples * period_s, 1.0 - kRounding);
        EXPECT_LE(bank.fastest() * period_s, 1.5 + kRounding);
      }
    }
}

TEST(ModeBanks, ScaleWithTheUnitOfTime) {
  const auto seconds = mode_banks(0.01, 10.0, 100), milliseconds = mode_banks(10.0, 10000.0, 100);
  ASSERT_EQ(seconds.size(), milliseconds.size());
  for (std::size_t i = 0; i < seconds.size(); ++i)
    EXPECT_NEAR(seconds[i].slowest(), 1000.0 * milliseconds[i].slowest(), kRounding * seconds[i].slowest());
}

TEST(ModeBanks, HaveAtMostAsManyRowsAsManyChannelsAllow) {
  for (const int most : {1, 2, 4})
    for (const ModeBank& bank : mode_banks(0.01, 10.0, most)) EXPECT_LE(bank.rows(), std::max(most, 2));
}

}  // namespace
}  // namespace nlo::trainer
