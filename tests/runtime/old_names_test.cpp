// SPDX-License-Identifier: MIT
// Names of version 0.2 still compile, with a deprecation warning, and have their old meaning.
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

TEST(OldNames, ScreenedAndTrustedReturnTheUsableOutputs) {
  const Model m = quiet_model();
  Monitor<Model> old_name(m), older_name(m), own(m);
  Fake observer;
  for (const double y : {0.0, 7.0, 40.0, -40.0}) {
    const double kept = own.usable_outputs(y, observer);
    for (const double old : {old_name.trusted(y, observer), older_name.screened(y, observer)})
      EXPECT_TRUE(kept == old || (std::isnan(kept) && std::isnan(old))) << y;
    (void)own.watch(observer, {{0.0}});
    (void)old_name.watch(observer, {{0.0}});
    (void)older_name.watch(observer, {{0.0}});
  }
}

}  // namespace
}  // namespace nlo::monitor_tests
