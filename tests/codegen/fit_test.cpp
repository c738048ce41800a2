// SPDX-License-Identifier: MIT
// The budget and the refusals; whether the table holds is for tests/embedded/fit.sh, which links programs.
#include "codegen/export/fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/codegen/example_models.h"
#include "tests/support/thrown_message.h"

namespace nlo::codegen {
namespace {

using testing::HasSubstr;
using testing::Not;

ExportOptions in(ScalarType scalar) {
  ExportOptions options;
  options.scalar = scalar;
  return options;
}

TEST(Budget, ReadsAnySubset) {
  const Budget all = budget("flash=32K,ram=2.5k,mac=5000,core=m4f");
  EXPECT_EQ(all.flash, 32768);
  EXPECT_EQ(all.ram, 2560);
  EXPECT_EQ(all.multiply_adds, 5000);
  EXPECT_EQ(all.core, "m4f");
  EXPECT_EQ(budget("flash=1M").flash, 1048576);
  EXPECT_FALSE(budget("flash=1M").ram);
  EXPECT_EQ(budget("mac=5K").multiply_adds, 5000);
}

TEST(Budget, BadOnesAreRefused) {
  for (const char* text : {"", "flash", "flash=", "=1", "flash=x", "flash=0", "ram=-1", "ram=nan", "flash=32KB",
                           "flash=1,", "flash=1,flash=2", "mac=1e300", "core=m3", "size=1"})
    EXPECT_THAT(thrown_message([&] { budget(text); }), HasSubstr("--fit")) << text;
}

TEST(Needs, WhatTheModelDecidesIsExact) {
  for (const Need& need : needs(PreparedExport(tiny_model(), in(ScalarType::kFloat)))) {
    EXPECT_EQ(need.constants, 168);  // as tests/golden/tiny.h states, and compile_exports.sh counts
    EXPECT_EQ(need.observer, 20);
    EXPECT_EQ(need.multiply_adds, 6 + 12);
  }
}

TEST(Needs, LargerNetworksNeedMoreOfEverything) {
  for (const ScalarType scalar : {ScalarType::kFloat, ScalarType::kInt16}) {
    const std::vector<Need> small = needs(PreparedExport(tiny_model(), in(scalar))),
                            large = needs(PreparedExport(paper_model(), in(scalar)));
    ASSERT_EQ(small.size(), 4U);
    for (std::size_t i = 0; i < small.size(); ++i) {
      EXPECT_LT(small[i].constants, large[i].constants);
      EXPECT_LT(small[i].code, large[i].code);
      EXPECT_LT(small[i].stack, large[i].stack);
      EXPECT_LT(small[i].multiply_adds, large[i].multiply_adds);
    }
  }
}

TEST(Needs, WhatTheTableDoesNotKnowIsRefused) {
  EXPECT_THAT(thrown_message([] { needs(PreparedExport(driven_model(), {})); }), HasSubstr("this model is driven_kkl"));
  EXPECT_THAT(thrown_message([] { needs(PreparedExport(tiny_model(), in(ScalarType::kDouble))); }),
              HasSubstr("emulate double"));
}

TEST(Shortfall, NamesCoreAmountAndMend) {
  const std::vector<Need> all = needs(PreparedExport(paper_model(), in(ScalarType::kFloat)));
  EXPECT_EQ(shortfall(all, budget("flash=64K,ram=2K,mac=10000")), "");
  const std::string short_of_all = shortfall(all, budget("flash=32K,ram=100,mac=5000"));
  for (const char* part : {"multiply-adds 7759 of 5000, 2759 too many", "M0+ flash", "M33 RAM", "core=m4f"})
    EXPECT_THAT(short_of_all, HasSubstr(part));
  const std::string short_of_one = shortfall(all, budget("flash=32K,core=m7"));
  EXPECT_THAT(short_of_one, HasSubstr("M7 flash"));
  EXPECT_THAT(short_of_one, Not(HasSubstr("M4F")));
  // The very bytes are enough, one less is not.
  Budget exact = budget("core=m4f");
  exact.flash = all[1].flash();
  exact.ram = all[1].ram();
  EXPECT_EQ(shortfall(all, exact), "");
  exact.flash = *exact.flash - 1;
  EXPECT_THAT(shortfall(all, exact), HasSubstr("1 too many"));
}

}  // namespace
}  // namespace nlo::codegen
