// SPDX-License-Identifier: MIT
// Scales and domain are computed from all samples that T* reads in flight, also from samples whose truth is masked.
#include <gtest/gtest.h>

#include "codegen/model/domain.h"
#include "codegen/replay/reference_observer.h"
#include "tests/support/mirrored.h"
#include "tests/training/training_testing.h"
#include "trainer/data/transient.h"
#include "trainer/learn/training/no_progress.h"
#include "trainer/learn/training/objective.h"
#include "trainer/learn/training/train.h"
#include "trainer/structures/for_each_sample.h"
#include "trainer/structures/kkl_family.h"

namespace nlo::trainer {
namespace {

using testing::harmonics;
using testing::small_experiment;

/// As on a rig: velocities come from a zero-phase filter whose ends are masked, the observer starts at any state, and
/// clocks show T* the time since the start. The faster clock has decayed before the first unmasked sample.
Experiment rig_experiment() {
  Experiment experiment = small_experiment();
  experiment.observer.pairs = {{-4.0, 6.0}, {-8.0, 10.0}};
  experiment.observer.eigenvalues = {};
  experiment.observer.learn_eigenvalues = false;
  experiment.observer.output_injection = Injection::kUnitGain;
  experiment.observer.start = LatentStart::kSteady;
  experiment.observer.features = FeatureSet::kLatentMinusOutput;
  experiment.observer.clocks_s = {0.02, 0.2};
  experiment.inverse_map.hidden = {12};
  experiment.inverse_map.linear_path = true;
  experiment.training.segment_s = 1.5;
  experiment.training.steps = 400;
  experiment.training.trajectories_per_step = 32;
  experiment.training.samples_per_step = 1024;
  experiment.training.validate_every = 50;
  return experiment;
}

constexpr int kMasked = 10;  // samples, half a second, after which exp(-.5 / .02) = 1e-11 of the faster clock is left

Dataset masked_runs(unsigned seed) {
  Dataset data = harmonics(std::vector<int>(12, 100), false, seed);
  for (Trajectory& run : data.trajectories) {
    run.weight.head(kMasked).setZero();
    run.weight.tail(kMasked).setZero();
  }
  return data;
}

struct Normalised {
  explicit Normalised(const Experiment& e, const Dataset& d)
      : experiment(e),
        dataset(d),
        data(dataset),
        pool(1),
        structure(make_structure(experiment, false, dataset.outputs, dataset.states)),
        objective(experiment, structure, data, pool),
        flight(objective.roll_out_flight(initial_dynamics(structure, experiment).data())) {
    normalise(structure, flight);
  }
  Experiment experiment;
  Dataset dataset;
  TrainingData data;
  ThreadPool pool;
  ObserverStructure structure;
  Objective objective;
  const Rollout& flight;
};

TEST(Normalisation, ProductWithAClockHasTheScaleOfItsFeature) {
  Experiment experiment = rig_experiment();
  experiment.observer.own.set<KklConfig>().clock_products = ClockProductSet::kAll;
  const Normalised normalised(experiment, masked_runs(1));
  const std::vector<Feature>& features = normalised.structure.features;
  std::size_t products = 0;
  for (const Feature& feature : features) {
    if (feature.clock < 0) continue;
    ++products;
    const Feature& factor = features[static_cast<std::size_t>(feature.without)];
    EXPECT_EQ(feature.latent, factor.latent);
    EXPECT_EQ(feature.mean, factor.mean);
    EXPECT_EQ(feature.scale, factor.scale);
  }
  EXPECT_EQ(products, 2 * (features.size() - products - 2));  // each feature except the two clocks, multiplied by both
}

TEST(Normalisation, FeaturesStayWithinTheirScaleWhereTheTruthIsMasked) {
  const Normalised normalised(rig_experiment(), masked_runs(1));
  // A harmonic stays within 1.5 standard deviations, its transient within a few more. With scales from the unmasked
  // samples only, the clock of 0.02 s would reach 1e10.
  EXPECT_LT(largest_feature(normalised.structure, normalised.dataset.outputs, normalised.flight).reach, 20.0);
}

TEST(Normalisation, ClocksHaveTheirKnownRange) {
  const Normalised normalised(rig_experiment(), masked_runs(1));
  int clocks = 0;
  for (const Feature& feature : normalised.structure.features) {
    if (!is_clock(normalised.structure, feature)) continue;
    ++clocks;
    EXPECT_EQ((1.0F - feature.mean) / feature.scale, 1.0F) << "at a start";
    EXPECT_EQ((0.0F - feature.mean) / feature.scale, -1.0F) << "long after";
  }
  EXPECT_EQ(clocks, 2);
}

TEST(Normalisation, MasksAffectOnlyTheTruth) {
  Dataset masked = masked_runs(1);
  // Masked truth may have any value.
  for (Trajectory& run : masked.trajectories) run.states.leftCols(kMasked).setConstant(1e6);
  Dataset cut = masked;
  for (Trajectory& run : cut.trajectories) run.states.leftCols(kMasked).setZero();
  const Normalised a(rig_experiment(), masked), b(rig_experiment(), cut);
  EXPECT_EQ(a.structure.state_mean, b.structure.state_mean);
  EXPECT_EQ(a.structure.state_scale, b.structure.state_scale);
}

TEST(Normalisation, WithMirrorTheMeansOfOddSignalsVanish) {
  Experiment experiment = rig_experiment();
  experiment.training.mode = TrainingMode::kFullBatch;
  experiment.training.segment_s = 0.0;
  const Normalised normalised(experiment, testing::mirrored(masked_runs(1)));
  constexpr float kSummation = 1e-5F;  // relative to the scale: float32 features, summed in double
  for (const Feature& feature : normalised.structure.features) {
    if (is_clock(normalised.structure, feature)) continue;
    EXPECT_LT(std::abs(feature.mean), kSummation * feature.scale);
  }
  for (std::size_t i = 0; i < normalised.structure.state_mean.size(); ++i)
    EXPECT_LT(std::abs(normalised.structure.state_mean[i]), kSummation * normalised.structure.state_scale[i]);
}

TEST(Normalisation, ADroppedTransientAffectsNeitherTheScaleNorTheDomain) {
  Experiment experiment = small_experiment();
  experiment.observer.pairs = {};
  experiment.observer.eigenvalues = {-2.0};
  experiment.observer.learn_eigenvalues = false;
  experiment.training.mode = TrainingMode::kFullBatch;
  Dataset steady = harmonics({100, 100}, false);
  for (Trajectory& run : steady.trajectories) run.outputs.setOnes();  // z goes from 0 to 1/2
  const auto lowest = [&](const Dataset& data) {
    const TrainingResult result = train(experiment, data, data, {});
    return result.model.latent_min(0);
  };
  Dataset dropped = steady;
  drop_transient(dropped, 3.0);  // only 1/2 (1 - exp(-6)) = .4988 is left of it
  EXPECT_LT(lowest(steady), 0.0) << "control: the domain contains the transient";
  EXPECT_GT(lowest(dropped), 0.49);
}

TEST(Normalisation, DomainIgnoresTheOutputLevelIfTStarReadsItRelativeToZ) {
  Dataset elsewhere = masked_runs(2);
  for (Trajectory& run : elsewhere.trajectories) run.outputs.array() += 20.0;
  const auto share = [&](const Experiment& experiment) {
    const TrainingResult result = train(experiment, masked_runs(1), masked_runs(2), {});
    codegen::ReferenceObserver<double> observer(result.model);
    const codegen::LatentDomain domain(result.model);
    double inside = 0.0, samples = 0.0;
    for (const Trajectory& run : elsewhere.trajectories) {
      const auto flown = observer.run(run.outputs, {}, run.time_s, true);
      // Unclamped readings: clamping to the range of measurements is tested elsewhere.
      const Eigen::MatrixXd z = flown.z, y = flown.y;
      for (Eigen::Index k = 0; k < run.samples(); ++k, samples += 1.0)
        inside += domain.contains(z.col(k), y.col(k)) ? 1.0 : 0.0;
    }
    return inside / samples;
  };
  Experiment experiment = rig_experiment();
  experiment.training.steps = 10;
  EXPECT_GT(share(experiment), 0.99);
  experiment.observer.features = FeatureSet::kLatent;
  EXPECT_LT(share(experiment), 0.1) << "control: T* reads z itself";
}

/// Regression test: for the shipped rig, the best model of each seed was that of step 0.
TEST(Normalisation, ARigWithMaskedEndsAndClocksLearnsAndFliesInItsDomainFromTheFirstSample) {
  const Dataset validation = masked_runs(2);
  for (const Dataset& training : {masked_runs(1), testing::mirrored(masked_runs(1))}) {
    const Experiment experiment = rig_experiment();
    const TrainingResult result = train(experiment, training, validation, {});
    EXPECT_EQ(result.outcome, TrainOutcome::kFinished) << result.message;
    EXPECT_LT(result.validation_rmse, 0.9 * result.metrics.front().validation_rmse)
        << "not better than ridge regression";

    codegen::ReferenceObserver<double> observer(result.model);
    const codegen::LatentDomain domain(result.model);
    double in_domain = 0.0, samples = 0.0, reach = 0.0, most = 0.0;
    for (const Trajectory& run : validation.trajectories) {
      const auto flown = observer.run(run.outputs, {}, run.time_s, true);
      for (Eigen::Index k = 0; k < run.samples(); ++k, samples += 1.0) {
        const bool inside = domain.contains(flown.z.col(k), flown.y.col(k));
        in_domain += inside ? 1.0 : 0.0;
        EXPECT_TRUE(inside || k > 0) << "the first sample of a run";
      }
      reach = std::max(reach, flown.x_hat.cwiseAbs().maxCoeff());
      most = std::max(most, run.states.cwiseAbs().maxCoeff());
    }
    EXPECT_GE(in_domain, 0.99 * samples);
    EXPECT_LT(reach, 2.0 * most) << "including masked samples";
  }
}

}  // namespace
}  // namespace nlo::trainer
