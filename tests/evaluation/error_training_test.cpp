// SPDX-License-Identifier: MIT
// [inverse_map] error: what training adds to a model, and that it changes nothing else.
#include <gtest/gtest.h>

#include <cmath>

#include "codegen/model_file/model_file.h"
#include "tests/training/testing.h"
#include "trainer/evaluation/evaluate.h"
#include "trainer/training/train.h"

namespace nlo::trainer {
namespace {

Experiment oscillator_experiment() {
  Experiment experiment = testing::small_experiment();
  experiment.inverse_map.hidden = {12};
  experiment.training.steps = 600;
  experiment.training.samples_per_step = 1000;
  experiment.training.noise = {NoiseKind::kGaussian, 0.2};
  return experiment;
}

codegen::Model trained(Experiment experiment, bool error) {
  experiment.inverse_map.error = error;
  return train(experiment, testing::van_der_pol(40, 20.0, 1), testing::van_der_pol(40, 20.0, 2), {}).model;
}

TEST(ErrorTraining, ChangesNothingElseOfTheModel) {
  Experiment experiment = oscillator_experiment();
  experiment.training.steps = 20;
  codegen::Model with = trained(experiment, true);
  ASSERT_TRUE(with.error);
  with.error.reset();
  EXPECT_EQ(codegen::to_json(with), codegen::to_json(trained(experiment, false)));
}

TEST(ErrorTraining, GivesTheSameBytesForAnyNumberOfThreads) {
  Experiment experiment = oscillator_experiment();
  experiment.training.steps = 20;
  const std::string one = codegen::to_json(trained(experiment, true));
  experiment.threads = 3;
  EXPECT_EQ(codegen::to_json(trained(experiment, true)), one);
}

TEST(ErrorTraining, CoversWhatItSaysOnRunsThatItHasNotSeen) {
  const codegen::Model model = trained(oscillator_experiment(), true);
  const Dataset fresh = testing::van_der_pol(100, 20.0, 3);
  const NoiseConfig noise{NoiseKind::kGaussian, 0.2};
  const auto found = evaluate("", observer_estimator(model, true), fresh, noise, 7, 1).coverage;
  ASSERT_TRUE(found);
  // Errors of a run are correlated over its 2 s or so: 100 runs of 20 s are 1,000 draws, 40 of the calibration 400.
  // Four deviations of their difference: 4 sqrt(p (1 - p) (1 / 1000 + 1 / 400)).
  const auto tolerance = [](double p) { return 4.0 * std::sqrt(p * (1.0 - p) * (1.0 / 1000.0 + 1.0 / 400.0)); };
  for (Eigen::Index i = 0; i < 2; ++i) {
    EXPECT_NEAR(found->share_68(i), 0.68, tolerance(0.68)) << i;
    EXPECT_NEAR(found->share_95(i), 0.95, tolerance(0.95)) << i;
  }

  codegen::Model wrong = model;  // the control: a sigma that is wrong by a third is seen
  wrong.error->factor_68 *= 1.4;
  const auto seen = evaluate("", observer_estimator(wrong, true), fresh, noise, 7, 1).coverage;
  for (Eigen::Index i = 0; i < 2; ++i) EXPECT_GT(std::abs(seen->share_68(i) - 0.68), tolerance(0.68)) << i;
}

}  // namespace
}  // namespace nlo::trainer
