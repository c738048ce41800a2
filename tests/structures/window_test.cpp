// SPDX-License-Identifier: MIT
// A window of measurements as an observer: what training rolls out is what flies, and T* learns from it.
#include <gtest/gtest.h>

#include <string>

#include "codegen/base/error.h"
#include "codegen/replay/reference_observer.h"
#include "tests/training/testing.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/training/train.h"

namespace nlo::trainer {
namespace {

using testing::harmonics;

Experiment window_experiment(int samples) {
  const std::string text =
      "name = \"w\"\n[plant]\nmodel = \"van_der_pol\"\n[simulation]\ninitial_low = [-1.0, -1.0]\ninitial_high = [1.0, "
      "1.0]\n[observer]\nstructure = \"window\"\nsamples = " +
      std::to_string(samples) +
      "\n[inverse_map]\nhidden = [8]\nlinear_path = true\n[training]\nsteps = 60\nlearning_rate = 0.01\n"
      "trajectories_per_step = 8\nsamples_per_step = 200\n";
  Experiment experiment = parse_experiment(text, "window.toml");
  experiment.threads = 1;
  return experiment;
}

TEST(Window, RollsOutWhatFlies) {
  // The latent states that training has seen lie in the flown model's domain, gaps and jitter included: its margin is a
  // tenth, so that a window that is filled otherwise falls out of it.
  for (const bool jittered : {false, true}) {
    Dataset data = harmonics({60, 90, 75}, jittered);
    if (jittered) data.trajectories[1].time_s.tail(40).array() += 0.3;  // a gap of seven samples
    const TrainingResult result = train(window_experiment(5), data, data, {});
    ASSERT_EQ(result.model.nz(), 5);
    codegen::ReferenceObserver<double> observer(result.model);
    Eigen::VectorXd lowest = Eigen::VectorXd::Constant(5, 1e9), highest = -lowest;
    double squares = 0.0, samples = 0.0;
    for (const Trajectory& run : data.trajectories) {
      const codegen::Run flown = observer.run(run.outputs, {}, run.time_s, data.uniform);
      lowest = lowest.cwiseMin(flown.z.rowwise().minCoeff());
      highest = highest.cwiseMax(flown.z.rowwise().maxCoeff());
      squares += (flown.x_hat - run.states).squaredNorm();
      samples += static_cast<double>(run.samples());
    }
    const Eigen::VectorXd range = highest - lowest;
    EXPECT_LT((result.model.latent_min - (lowest - 0.1 * range)).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_LT((result.model.latent_max - (highest + 0.1 * range)).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_NEAR(result.validation_rmse, std::sqrt(squares / samples), 1e-3 * result.validation_rmse);
  }
}

TEST(Window, AFirstMeasurementFillsItAndAGapLiesOnTheRamp) {
  const Dataset data = harmonics({40}, false);
  codegen::ReferenceObserver<double> observer(train(window_experiment(4), data, data, {}).model);
  const auto y = [](double value) { return Eigen::VectorXd::Constant(1, value); };
  observer.step(y(0.5));
  EXPECT_EQ(observer.latent(), Eigen::VectorXd::Constant(4, 0.5));
  observer.step(y(0.8), {}, 3.0 * data.sample_period_s);
  EXPECT_LT((observer.latent() - Eigen::Vector4d(0.8, 0.7, 0.6, 0.5)).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Window, MoreSamplesThanOneTellAVelocity) {
  const Dataset data = harmonics({80, 80, 80}, false);
  const auto error = [&](int samples) { return train(window_experiment(samples), data, data, {}).validation_rmse; };
  EXPECT_LT(error(3), 0.5 * error(1)) << "control: one position has no velocity";
}

TEST(Window, RefusesWhatItHasNoUseFor) {
  const auto message = [](const std::string& line) -> std::string {
    try {
      parse_experiment(
          "name = \"w\"\n[plant]\nmodel = \"van_der_pol\"\n[simulation]\ninitial_low = [-1.0, -1.0]\ninitial_high = "
          "[1.0, 1.0]\n[observer]\nstructure = \"window\"\n" +
              line + "\n",
          "w.toml");
    } catch (const codegen::Error& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(message("samples = 4"), "no error");
  EXPECT_EQ(message("eigenvalues = [-1.0]").find("w.toml:9: [observer] eigenvalues has no use"), 0U);
  EXPECT_EQ(message("samples = 0").find("w.toml:9: [observer] samples"), 0U) << message("samples = 0");
}

}  // namespace
}  // namespace nlo::trainer
