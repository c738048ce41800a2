// SPDX-License-Identifier: MIT
#include "trainer/training/objective.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "codegen/reference/observer.h"
#include "tests/training/testing.h"

namespace nlo::trainer {
namespace {

using testing::harmonics;
using testing::make_luenberger;
using testing::small_experiment;

// Segments of unequal lengths, in two groups of eight lanes, the second one not full.
const std::vector<int> kUnequal = {40, 25, 60, 33, 40, 12, 51, 40, 28, 60, 7};

/// An objective with all that it refers to, normalised, at its initial parameters moved off their special values.
struct Problem {
  Experiment experiment;
  Dataset dataset;
  TrainingData data;
  ObserverStructure structure;
  ThreadPool pool{1};
  Objective objective;
  std::vector<float> parameters;

  Problem(const Experiment& e, const Dataset& d)
      : experiment(e),
        dataset(d),
        data(dataset),
        structure(make_structure(experiment, dataset.outputs, dataset.states)),
        objective(experiment, structure, data, pool) {
    normalise_dynamics(structure, data, pool);
    const Rollout& rollout = objective.roll_out_flight(initial_dynamics(structure, experiment).data());
    normalise(structure, rollout);
    parameters = initial_parameters(structure, experiment, rollout);
    std::mt19937 random(4);
    std::uniform_real_distribution<float> uniform(-0.2F, 0.2F);
    const std::size_t first = static_cast<std::size_t>(structure.latent.learned);
    for (std::size_t i = first; i < parameters.size(); ++i) {
      parameters[i] += uniform(random);  // biases start at zero
    }
  }
  Problem(const Problem&) = delete;

  /// Scales depend on the segments that training draws: for comparisons both must have the same.
  void take_scales_of(const Problem& other) {
    structure.features = other.structure.features;
    structure.state_mean = other.structure.state_mean;
    structure.state_scale = other.structure.state_scale;
  }
  double loss(const std::vector<float>& at, long step) { return objective.evaluate(at.data(), step, nullptr).loss; }
  std::vector<float> gradient(long step) {
    std::vector<float> out(parameters.size());
    objective.evaluate(parameters.data(), step, out.data());
    return out;
  }
};

constexpr long kSomeStep = 5;

/// The gradient, for every parameter, against fourth-order central differences of the objective itself.
void expect_gradient_meets_differences(const Experiment& experiment, const Dataset& dataset) {
  // The loss comes in float32 sums, good to 1e-7 of itself: 2e-5 of the loss after division by kStep, measured. The
  // truncated term, kStep^4 / 30 times the fifth derivative, is as large for the steepest variant (silu).
  constexpr float kStep = 0.015F;
  constexpr double kTolerance = 1.2e-4;
  Problem problem(experiment, dataset);
  const std::vector<float> gradient = problem.gradient(kSomeStep);
  const double loss = problem.loss(problem.parameters, kSomeStep);
  double largest = 0.0;
  for (std::size_t i = 0; i < gradient.size(); ++i) {
    const auto moved = [&](float by) {
      std::vector<float> at = problem.parameters;
      at[i] += by;
      return problem.loss(at, kSomeStep);
    };
    // Float32 parameters: what was moved is not exactly the step.
    const double width =
        static_cast<double>(problem.parameters[i] + kStep) - static_cast<double>(problem.parameters[i] - kStep);
    const double difference =
        (8.0 * (moved(kStep) - moved(-kStep)) - (moved(2 * kStep) - moved(-2 * kStep))) / (6.0 * width);
    largest = std::max(largest, std::abs(difference));
    ASSERT_NEAR(static_cast<double>(gradient[i]), difference, kTolerance * (1.0 + loss)) << "parameter " << i;
  }
  ASSERT_GT(largest, 200.0 * kTolerance * (1.0 + loss)) << "the tolerance would pass a gradient of zero";
}

struct Variant {
  const char* name;
  std::function<void(Experiment&)> change;
};

const std::vector<Variant>& variants() {
  static const std::vector<Variant> all = {
      {"plain", [](Experiment&) {}},
      {"full_batch", [](Experiment& e) { e.training.mode = TrainingMode::kFullBatch; }},
      {"gaussian_noise",
       [](Experiment& e) {
         e.training.noise = {NoiseKind::kGaussian, 0.3};
       }},
      {"uniform_noise",
       [](Experiment& e) {
         e.training.noise = {NoiseKind::kUniform, 0.5};
       }},
      {"noise_levels",
       [](Experiment& e) {
         e.training.noise = {NoiseKind::kGaussian, 0.3};
         e.training.noise_level_max = 2.0;
       }},
      {"mirror", [](Experiment& e) { e.training.mirror = true; }},
      {"normalised_loss", [](Experiment& e) { e.loss.scale = ErrorScale::kNormalised; }},
      {"eigenvalue_penalty", [](Experiment& e) { e.loss.weights["eigenvalue_penalty"] = 0.05; }},
      {"segments", [](Experiment& e) { e.training.segment_s = 1.0; }},
      {"integral",
       [](Experiment& e) {
         e.loss.reduction = Reduction::kIntegral;
         e.loss.weights["eigenvalue_penalty"] = 0.01;
       }},
      {"terminal_beside_running",
       [](Experiment& e) {
         e.loss.weights["terminal"] = 0.8;
         e.loss.weights["state_error"] = 0.5;
       }},
      {"terminal_alone",
       [](Experiment& e) {
         e.loss.weights["terminal"] = 1.0;
         e.loss.weights["state_error"] = 0.0;
         e.training.segment_s = 1.0;
       }},
      {"maps_jointly",
       [](Experiment& e) {
         e.loss.weights["map_consistency"] = 1.0;
         e.loss.weights["reconstruction"] = 1.0;
         e.loss.weights["state_error"] = 0.0;
         e.forward_map.hidden = {4};
       }},
      {"maps_apart_mirrored",
       [](Experiment& e) {
         e.loss.weights["map_consistency"] = 0.5;
         e.loss.scale = ErrorScale::kNormalised;
         e.forward_map.hidden = {4};
         e.training.mirror = true;
       }},
      {"backprop",
       [](Experiment& e) {
         e.training.gradient = LatentGradient::kBackprop;
         e.observer.hold = Hold::kRk4;
       }},
      {"adjoint",
       [](Experiment& e) {
         e.training.gradient = LatentGradient::kAdjoint;
         e.observer.hold = Hold::kRk4;
       }},
      {"general",
       [](Experiment& e) {
         e.observer.structure = "general";
         e.dynamics.hidden = {5};
       }},
      {"luenberger_by_adjoint",
       [](Experiment& e) {
         make_luenberger(e);
         e.training.gradient = LatentGradient::kAdjoint;
         e.training.noise = {NoiseKind::kGaussian, 0.3};
       }},
      {"luenberger_integral",
       [](Experiment& e) {
         make_luenberger(e);
         e.loss.reduction = Reduction::kIntegral;
         e.loss.weights["terminal"] = 0.5;
       }},
      {"early_samples",
       [](Experiment& e) {
         e.training.early_s = 0.3;
         e.training.early_share = 0.5;
       }},
      {"ticks_drawn_many_times", [](Experiment& e) { e.training.samples_per_step = 5000; }},
      {"linear_path", [](Experiment& e) { e.inverse_map.linear_path = true; }},
      {"linear_path_alone",
       [](Experiment& e) {
         e.inverse_map.hidden = {};
         e.inverse_map.linear_path = true;
       }},
      {"silu", [](Experiment& e) { e.inverse_map.activation = "silu"; }},
      {"steady_start_unit_gain_reading_output",
       [](Experiment& e) {
         e.observer.start = LatentStart::kSteady;
         e.observer.output_injection = Injection::kUnitGain;
         e.observer.features = FeatureSet::kLatentAndOutput;
       }},
      {"reading_latent_minus_output_and_a_clock",
       [](Experiment& e) {
         e.observer.output_injection = Injection::kUnitGain;
         e.observer.features = FeatureSet::kLatentMinusOutput;
         e.observer.clocks_s = {0.5};
       }},
      {"zero_order_hold", [](Experiment& e) { e.observer.hold = Hold::kZeroOrder; }},
      {"rk4", [](Experiment& e) { e.observer.hold = Hold::kRk4; }}};
  return all;
}

Dataset masked(Dataset data) {
  for (Trajectory& run : data.trajectories) {
    for (Eigen::Index k = 0; k < run.samples(); k += 3) run.weight(k) = 0.0;
    for (Eigen::Index k = 1; k < run.samples(); k += 5) run.weight(k) = 0.25;
  }
  return data;
}

void expect_every_variant_meets_differences(const Dataset& dataset) {
  for (const Variant& variant : variants()) {
    SCOPED_TRACE(variant.name);
    Experiment experiment = small_experiment();
    variant.change(experiment);
    expect_gradient_meets_differences(experiment, dataset);
    if (::testing::Test::HasFatalFailure()) return;
  }
}

TEST(Objective, GradientMeetsDifferencesOfTheObjectiveInEveryVariant) {
  expect_every_variant_meets_differences(harmonics(kUnequal, false));
}

TEST(Objective, GradientMeetsDifferencesOfTheObjectiveOnJitteredSamples) {
  expect_every_variant_meets_differences(harmonics(kUnequal, true));
}

TEST(Objective, GradientMeetsDifferencesOfTheObjectiveOnWeightedSamples) {
  expect_every_variant_meets_differences(masked(harmonics(kUnequal, false)));
}

/// Divides estimates and truth of each state by its scale.
void in_units_of(const std::vector<float>& scale, codegen::Model& model, Dataset& dataset) {
  const Eigen::VectorXd units =
      Eigen::VectorXf::Map(scale.data(), static_cast<Eigen::Index>(scale.size())).cast<double>();
  codegen::inverse_map(model)->output_mean.array() /= units.array();
  codegen::inverse_map(model)->output_scale.array() /= units.array();
  for (Trajectory& run : dataset.trajectories) run.states.array().colwise() /= units.array();
}

TEST(Objective, ErrorIsThatOfTheModelRunPlainly) {
  // Training and the model that it writes agree: the float32 of the filter and of T*, and nothing else, between them.
  constexpr double kTolerance = 2e-6;
  constexpr double kOdeTolerance = 1e-5;  // long steps of jittered samples are split when flown: RK4's own error
  for (const bool jittered : {false, true}) {
    for (const Variant& variant : variants()) {
      SCOPED_TRACE(variant.name);
      Experiment experiment = small_experiment();
      variant.change(experiment);
      experiment.training.noise = {};
      Problem problem(experiment, masked(harmonics(kUnequal, jittered)));
      const double rmse = problem.objective.validate(problem.parameters.data());
      codegen::Model model = to_model(problem.structure, problem.parameters.data(), experiment, problem.dataset,
                                      problem.objective.rollout());
      Dataset dataset = problem.dataset;
      if (experiment.loss.is_normalised()) in_units_of(problem.structure.state_scale, model, dataset);
      const double flown = codegen::linear_latent(model) != nullptr ? testing::plain_rmse(model, dataset)
                                                                    : testing::reference_rmse(model, dataset);
      EXPECT_NEAR(rmse, flown, (codegen::linear_latent(model) != nullptr ? kTolerance : kOdeTolerance) * rmse);
    }
  }
}

TEST(Objective, ModelRecordsTheLargestActivationsOfTheSamplesFlownMaskedOrNot) {
  constexpr double kTolerance = 1e-4;  // float32 of the filter
  Experiment experiment = small_experiment();
  experiment.inverse_map.activation = "relu";
  experiment.observer.features = FeatureSet::kLatentAndOutput;
  experiment.training.noise = {};
  Dataset dataset = harmonics(kUnequal, false);
  dataset.trajectories[2].outputs.col(5) *= 50.0;  // masks are about the truth: the observer meets this
  for (Eigen::Index k = 5; k < dataset.trajectories[2].samples(); ++k) dataset.trajectories[2].weight(k) = 0.0;
  Problem problem(experiment, dataset);
  const codegen::Model model =
      to_model(problem.structure, problem.parameters.data(), experiment, problem.dataset, problem.objective.rollout());
  const codegen::Network& map = *codegen::inverse_map(model);
  std::vector<double> largest(map.layers.size() - 1, 0.0);
  for (const Trajectory& run : problem.dataset.trajectories) {
    Eigen::MatrixXd in(model.nz() + model.ny(), run.samples());
    in << codegen::ReferenceObserver<double>(model).run(run.outputs, {}, run.time_s, true).z, run.outputs;
    for (Eigen::Index k = 0; k < run.samples(); ++k) {
      Eigen::VectorXd a = (map.features * in.col(k) - map.feature_mean).cwiseQuotient(map.feature_scale);
      for (std::size_t l = 0; l < largest.size(); ++l) {
        a = (map.layers[l].weights * a + map.layers[l].bias).cwiseMax(0.0).eval();
        largest[l] = std::max(largest[l], a.maxCoeff());
      }
    }
  }
  ASSERT_EQ(map.largest_activations.size(), largest.size());
  for (std::size_t l = 0; l < largest.size(); ++l)
    EXPECT_NEAR(map.largest_activations[l], largest[l], kTolerance * largest[l]);
}

TEST(Objective, LossIsTheSquaredErrorInTheScaleItIsNamedIn) {
  constexpr double kTolerance = 1e-5;  // float32 sums
  Experiment experiment = small_experiment();
  experiment.training.mode = TrainingMode::kFullBatch;
  Problem physical(experiment, harmonics(kUnequal, false));
  const ObjectiveValue value = physical.objective.evaluate(physical.parameters.data(), 0, nullptr);
  EXPECT_NEAR(value.loss, value.rmse * value.rmse, kTolerance * value.loss);

  experiment.loss.scale = ErrorScale::kNormalised;
  Problem normalised(experiment, harmonics(kUnequal, false));
  const codegen::Model model = to_model(normalised.structure, normalised.parameters.data(), experiment,
                                        normalised.dataset, normalised.objective.rollout());
  double expected = 0.0;
  double total = 0.0;
  for (const Trajectory& run : normalised.dataset.trajectories) {
    const Eigen::MatrixXd error = testing::plain_estimates(model, run).states - run.states;
    expected += (codegen::inverse_map(model)->output_scale.cwiseInverse().asDiagonal() * error).squaredNorm();
    total += static_cast<double>(run.samples());
  }
  const ObjectiveValue scaled = normalised.objective.evaluate(normalised.parameters.data(), 0, nullptr);
  EXPECT_NEAR(scaled.loss, expected / total, kTolerance * scaled.loss);
  EXPECT_NEAR(scaled.rmse, std::sqrt(scaled.loss), kTolerance * scaled.rmse) << "the error has the scale of the loss";

  experiment.loss.weights["eigenvalue_penalty"] = 0.1;
  Problem penalised(experiment, harmonics(kUnequal, false));
  const double penalty = penalised.objective.evaluate(penalised.parameters.data(), 0, nullptr).loss - scaled.loss;
  EXPECT_NEAR(penalty, 0.1 * (4.0 + 9.0 + 1.0 + 16.0), kTolerance * penalty) << "(20): gamma |lambda|^2";
}

/// Loss and gradient with one sample's truth moved far off; the normalisation stays that of `problem`.
std::pair<double, std::vector<float>> with_truth_moved(Problem& problem, int sample) {
  std::vector<float>& states = problem.data.runs[2].states;
  const float before = states[static_cast<std::size_t>(sample)];
  states[static_cast<std::size_t>(sample)] = 1e4F;
  std::pair<double, std::vector<float>> result{problem.loss(problem.parameters, kSomeStep),
                                               problem.gradient(kSomeStep)};
  states[static_cast<std::size_t>(sample)] = before;
  return result;
}

TEST(Objective, MaskedSamplesDoNotMatter) {
  for (const auto mode : {TrainingMode::kFullBatch, TrainingMode::kRandomSamples}) {
    Experiment experiment = small_experiment();
    experiment.training.mode = mode;
    experiment.training.samples_per_step = 5000;  // so that every tick is drawn
    experiment.training.trajectories_per_step = 60;
    Dataset dataset = harmonics(kUnequal, false);
    dataset.trajectories[2].weight(10) = 0.0;
    Problem problem(experiment, dataset);
    const double loss = problem.loss(problem.parameters, kSomeStep);
    const std::vector<float> gradient = problem.gradient(kSomeStep);
    const auto [masked_loss, masked_gradient] = with_truth_moved(problem, 10);
    EXPECT_EQ(masked_loss, loss) << to_name(mode);
    EXPECT_EQ(masked_gradient, gradient) << to_name(mode);
    const auto [counted_loss, counted_gradient] = with_truth_moved(problem, 11);
    EXPECT_GT(counted_loss, 2.0 * loss) << "control, " << to_name(mode);
    EXPECT_NE(counted_gradient, gradient) << "control, " << to_name(mode);
  }
}

TEST(Objective, WeightsCountAsShares) {
  // A run that counts half, twice, is the run once.
  Experiment experiment = small_experiment();
  experiment.training.mode = TrainingMode::kFullBatch;
  const Dataset once = harmonics(kUnequal, false);
  Dataset twice = once;
  for (Trajectory& run : twice.trajectories) run.weight *= 0.5;
  const std::vector<Trajectory> copy = twice.trajectories;
  twice.trajectories.insert(twice.trajectories.end(), copy.begin(), copy.end());
  Problem one(experiment, once);
  Problem two(experiment, twice);
  constexpr double kTolerance = 1e-6;  // float32, summed in another order
  EXPECT_NEAR(two.loss(one.parameters, 0), one.loss(one.parameters, 0), kTolerance * one.loss(one.parameters, 0));
}

TEST(Objective, RandomSamplesAgreeWithFullBatchesInExpectation) {
  // Whole runs and short segments, runs of unequal length whose errors differ: every sample must be as likely.
  constexpr int kSteps = 400;
  constexpr double kStandardErrors = 4.0;
  // Runs of 100 samples or more: a segment reaches the first and last few samples of a run less often than the others.
  const Dataset dataset = harmonics({100, 300, 200, 150, 260, 120, 300, 180, 110, 220, 130}, false);
  Experiment experiment = small_experiment();
  experiment.training.mode = TrainingMode::kFullBatch;
  Problem full(experiment, dataset);
  const double expected = full.loss(full.parameters, 0);
  experiment.training.mode = TrainingMode::kRandomSamples;
  experiment.training.trajectories_per_step = 64;
  experiment.training.samples_per_step = 64 * 16;
  Problem random(experiment, dataset);
  random.take_scales_of(full);
  double sum = 0.0;
  double squares = 0.0;
  for (long step = 0; step < kSteps; ++step) {
    const double loss = random.loss(full.parameters, step);
    sum += loss;
    squares += loss * loss;
  }
  const double mean = sum / kSteps;
  const double error = std::sqrt((squares / kSteps - mean * mean) / kSteps);
  EXPECT_NEAR(mean, expected, kStandardErrors * error);
  EXPECT_LT(kStandardErrors * error, 0.02 * expected) << "control: the bound is sharp";
}

TEST(Objective, EarlyShareDrawsThatShareOfTheSamplesFromTheStart) {
  // Only samples before early_s are wrong, by a known amount: the loss tells their share.
  Experiment experiment = small_experiment();
  experiment.training.early_s = 0.5;  // 10 of 200 samples
  experiment.training.early_share = 0.4;
  experiment.training.trajectories_per_step = 64;
  experiment.training.samples_per_step = 64 * 50;
  Problem problem(experiment, harmonics(std::vector<int>(8, 200), false));
  const double before = problem.loss(problem.parameters, 0);
  for (auto& run : problem.data.runs) {
    for (std::size_t k = 0; k < 10; ++k) run.states[k] += 1000.0F;
  }
  const double share = (problem.loss(problem.parameters, 0) - before) / 1e6;
  // 20 of 50 ticks by rule, and of the other 30 one in twenty by chance; half a sample's worth of the error itself.
  EXPECT_NEAR(share, 0.4 + 0.6 / 20.0, 0.02);
}

TEST(Objective, DrawsAnewInEachStepAndTheSameInTheSameStep) {
  Experiment experiment = small_experiment();
  experiment.training.noise = {NoiseKind::kGaussian, 0.3};
  for (const auto mode : {TrainingMode::kFullBatch, TrainingMode::kRandomSamples}) {
    experiment.training.mode = mode;
    Problem problem(experiment, harmonics(kUnequal, false));
    const double first = problem.loss(problem.parameters, 0);
    EXPECT_NE(problem.loss(problem.parameters, 1), first) << to_name(mode);
    EXPECT_EQ(problem.loss(problem.parameters, 0), first) << to_name(mode);
    const double validated = problem.objective.validate(problem.parameters.data());
    problem.loss(problem.parameters, 7);
    EXPECT_EQ(problem.objective.validate(problem.parameters.data()), validated) << to_name(mode);
  }
}

TEST(Objective, NoiseHasTheNamedDeviation) {
  Experiment experiment = small_experiment();
  const Dataset dataset = harmonics(std::vector<int>(40, 500), false);
  for (const auto& [kind, deviation] :
       {std::pair{NoiseKind::kGaussian, 0.3}, std::pair{NoiseKind::kUniform, 0.3 / std::sqrt(3.0)}}) {
    experiment.training.noise = {kind, 0.3};
    Problem problem(experiment, dataset);
    const Rollout& rollout = problem.objective.roll_out_flight(problem.parameters.data());
    double sum = 0.0;
    double squares = 0.0;
    double count = 0.0;
    for (std::size_t g = 0; g < rollout.groups().size(); ++g) {
      const SegmentGroup& group = rollout.groups()[g];
      for (int l = 0; l < group.lanes; ++l) {
        const auto& run = problem.data.runs[static_cast<std::size_t>(rollout.segment(static_cast<int>(g), l).run)];
        for (int t = 0; t < group.length; ++t, count += 1.0) {
          const auto noise = static_cast<double>(group.outputs[group.at(0, t) + static_cast<std::size_t>(l)] -
                                                 run.outputs[static_cast<std::size_t>(t)]);
          sum += noise;
          squares += noise * noise;
        }
      }
    }
    // Five standard errors of a mean and of a deviation.
    EXPECT_NEAR(sum / count, 0.0, 5.0 * deviation / std::sqrt(count));
    EXPECT_NEAR(std::sqrt(squares / count), deviation, 5.0 * deviation / std::sqrt(2.0 * count));
  }
}

TEST(Objective, MirroredRunsOfAnOddMapCostTheSame) {
  // Without biases and means, tanh networks are odd: mirrored or not, the error is the same.
  Experiment experiment = small_experiment();
  experiment.training.mode = TrainingMode::kFullBatch;
  Problem plain(experiment, harmonics(kUnequal, false));
  experiment.training.mirror = true;
  Problem mirrored(experiment, harmonics(kUnequal, false));
  mirrored.take_scales_of(plain);
  mirrored.parameters = plain.parameters;
  for (Problem* problem : {&plain, &mirrored}) {
    for (Feature& feature : problem->structure.features) feature.mean = 0.0F;
    for (float& mean : problem->structure.state_mean) mean = 0.0F;
    for (const LayerView& layer : problem->structure.network.layers) {
      for (int o = 0; o < layer.out; ++o) {
        problem->parameters[static_cast<std::size_t>(problem->structure.latent.learned + layer.bias + o)] = 0.0F;
      }
    }
  }
  const double loss = plain.loss(plain.parameters, 0);
  EXPECT_NEAR(mirrored.loss(plain.parameters, 0), loss, 1e-6 * loss);
  plain.structure.state_mean[0] = mirrored.structure.state_mean[0] = 1.0F;
  const double shifted = plain.loss(plain.parameters, 0);
  EXPECT_GT(std::abs(mirrored.loss(plain.parameters, 0) - shifted), 1e-3 * shifted)
      << "control: some runs are mirrored";
}

/// The validation error at the same network, with position in units of `metres`.
double validated(ErrorScale scale, double metres) {
  Experiment experiment = small_experiment();
  experiment.loss.scale = scale;
  Dataset dataset = harmonics(kUnequal, false);
  for (Trajectory& run : dataset.trajectories) run.states.row(0) /= metres;
  Problem problem(experiment, dataset);
  return problem.objective.validate(problem.parameters.data());
}

TEST(Objective, ChoosesByErrorsThatNoUnitDecidesWhereTheLossIsNormalised) {
  constexpr double kFloat = 1e-5;  // sums of some 400 squares in float32
  const double in_metres = validated(ErrorScale::kNormalised, 1.0);
  EXPECT_NEAR(validated(ErrorScale::kNormalised, 1e-3), in_metres, kFloat * in_metres);
  EXPECT_GT(validated(ErrorScale::kPhysical, 1e-3), 100.0 * validated(ErrorScale::kPhysical, 1.0))
      << "control: the unit decides";
}

}  // namespace
}  // namespace nlo::trainer
