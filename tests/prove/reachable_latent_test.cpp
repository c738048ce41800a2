// SPDX-License-Identifier: MIT
// The reachable set of z: no readings lead out of it, and some readings reach its limits.
#include "trainer/prove/reachable_latent.h"

#include <gtest/gtest.h>

#include <random>

#include "codegen/model/latent_step.h"
#include "codegen/replay/reference_observer.h"
#include "codegen/replay/replay_inputs.h"
#include "codegen/replay/replay_run.h"
#include "tests/codegen/example_models.h"

namespace nlo::trainer {
namespace {

using codegen::Model;

std::vector<Model> linear_models() {
  std::vector<Model> models;
  for (Model& model : codegen::example_models())
    if (moves_linearly(model)) models.push_back(std::move(model));
  return models;
}

/// Returns the largest share of the hull, from its middle, that random readings reach.
double reached_at_random(const Model& model, const LatentHull& hull, unsigned seed) {
  codegen::ReferenceObserver<double> observer(model);
  const Eigen::MatrixXd gain = codegen::steady_gain(model);
  double largest = 0.0;
  std::mt19937 engine(seed);
  const Eigen::VectorXd low = codegen::reading_min(model), high = codegen::reading_max(model);
  for (int run = 0; run < 12; ++run) {
    observer.reset();
    Eigen::VectorXd reading = low;
    for (int k = 0; k < 3000; ++k) {
      for (Eigen::Index j = 0; j < reading.size();
           ++j)  // any value (also beyond the range), a limit, or the last value
        if (engine() % (run < 6 ? 2 : 40) == 0) {
          const double share = 1.2 * static_cast<double>(engine() % 1001) / 1000.0 - 0.1;
          const double end = engine() % 2 == 0 ? low(j) : high(j);
          reading(j) = engine() % 2 == 0 ? end : low(j) + (high(j) - low(j)) * share;
        }
      Eigen::VectorXd y = reading.head(model.ny());
      for (Eigen::Index j = 0; j < y.size(); ++j)
        if (engine() % 50 == 0) y(j) = std::nan("");
      observer.step(y, reading.segment(model.ny(), model.nu()));
      const Eigen::VectorXd z = observer.latent() - gain * codegen::turns_in(model, observer.output());
      const Eigen::VectorXd part = (z - hull.middle()).cwiseAbs().cwiseQuotient(0.5 * (hull.high - hull.low));
      largest = std::max(largest, part.maxCoeff());
    }
  }
  return largest;
}

TEST(ReachableLatent, ContainsZForAnyReadings) {
  unsigned seed = 1;
  for (const Model& model : linear_models()) {
    const LatentHull hull = reachable_latent(model);
    ASSERT_TRUE(hull.low.allFinite() && hull.high.allFinite()) << model.name;
    EXPECT_LE(reached_at_random(model, hull, ++seed), 1.0) << model.name;
    const LatentHull reached = reached_latent(model);
    for (Eigen::Index i = 0; i < model.nz(); ++i) {
      EXPECT_GE(reached.low(i), hull.low(i) - 1e-9 * std::abs(hull.low(i))) << model.name << " z" << i;
      EXPECT_LE(reached.high(i), hull.high(i) + 1e-9 * std::abs(hull.high(i))) << model.name << " z" << i;
    }
  }
}

TEST(ReachableLatent, SomeReadingsDriveZToItsLimits) {
  constexpr double kNearly = 0.99;
  for (const Model& model : {codegen::paper_model(), codegen::tiny_model(), codegen::hold_model("zero_order"),
                             codegen::hold_model("rk4"), codegen::commanded_model()}) {
    const LatentHull hull = reachable_latent(model), reached = reached_latent(model);
    const Eigen::VectorXd part = (reached.high - reached.low).cwiseQuotient(hull.high - hull.low);
    EXPECT_GE(part.minCoeff(), kNearly) << model.name << ": " << part.transpose();
  }
}

TEST(ReachableLatent, ControlTheReadingsDriveZOutOfTheInnerHalfOfTheHull) {
  int left = 0;
  for (const Model& model : linear_models()) {
    LatentHull half = reachable_latent(model);
    const Eigen::VectorXd middle = half.middle(), radius = 0.25 * (half.high - half.low);
    half = {middle - radius, middle + radius};
    const LatentHull reached = reached_latent(model);
    left += ((reached.high - half.high).array() > 0.0).any() || ((half.low - reached.low).array() > 0.0).any();
  }
  EXPECT_EQ(left, static_cast<int>(linear_models().size()));
}

}  // namespace
}  // namespace nlo::trainer
