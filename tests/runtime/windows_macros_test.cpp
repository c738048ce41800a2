// SPDX-License-Identifier: MIT
// The runtime and a generated header compile after the macros of <windows.h>.
#include <gtest/gtest.h>

#define min(a, b) (((a) < (b)) ? (a) : (b))
#define max(a, b) (((a) > (b)) ? (a) : (b))
#define abs(x) (((x) < 0) ? -(x) : (x))
#define near
#define far
#define small char
#define interface struct
#define IN
#define OUT
#define ERROR 0

#include <nlo/carried_observer.h>
#include <nlo/driven_kkl_observer.h>
#include <nlo/error_head.h>
#include <nlo/gated_observer.h>
#include <nlo/general_observer.h>
#include <nlo/kkl_batch.h>
#include <nlo/kkl_observer.h>
#include <nlo/luenberger_observer.h>
#include <nlo/monitor.h>
#include <nlo/prior_observer.h>
#include <nlo/quantised_map.h>
#include <nlo/quantised_units.h>

#include "tests/golden/watched.h"

#undef min
#undef max
#undef abs
#undef near
#undef far
#undef small
#undef interface
#undef IN
#undef OUT
#undef ERROR

namespace nlo {
namespace {

// Names are looked up when a template is instantiated, but macros replace its tokens where it is defined.
TEST(WindowsMacros, DoNotChangeTheRuntime) {
  EXPECT_EQ(square_root(4.0F), 2.0F);
  EXPECT_EQ(simd::smaller(1.0F, 2.0F), 1.0F);
  EXPECT_EQ(simd::larger(1.0F, 2.0F), 2.0F);
}

}  // namespace
}  // namespace nlo
