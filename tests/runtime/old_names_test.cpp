// SPDX-License-Identifier: MIT
// Names of version 0.2 still compile, with a warning, and mean what they meant.
#include <gtest/gtest.h>

#include <cmath>
#include <type_traits>

#include "nlo/mlp.h"
#include "tests/runtime/watched_fakes.h"

#pragma GCC diagnostic ignored "-Wdeprecated-declarations"

namespace nlo::monitor_tests {
namespace {

using Network = Mlp<Activation::kTanh, PackedDense<float, 3, 2>>;
static_assert(std::is_same_v<InverseMap<Network>, LearnedMap<Network>>);
static_assert(
    std::is_same_v<InverseMap<Network, LinearPath<float, 3, 2>>, LearnedMap<Network, LinearPath<float, 3, 2>>>);
static_assert(std::is_same_v<OutputRange<float, 2>, ReadingRange<float, 2>>);

TEST(OldNames, ScreenedIsTrusted) {
  const Model m = quiet_model();
  Monitor<Model> old_name(m), own(m);
  Fake observer;
  for (const double y : {0.0, 7.0, 40.0, -40.0}) {
    const double kept = own.trusted(y, observer), screened = old_name.screened(y, observer);
    EXPECT_TRUE(kept == screened || (std::isnan(kept) && std::isnan(screened))) << y;
    (void)own.watch(observer, {{0.0}});
    (void)old_name.watch(observer, {{0.0}});
  }
}

}  // namespace
}  // namespace nlo::monitor_tests
