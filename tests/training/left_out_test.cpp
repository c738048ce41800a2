// SPDX-License-Identifier: MIT
#include "trainer/choose/left_out.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <random>
#include <set>

#include "codegen/base/error.h"
#include "codegen/model_file/model_file.h"
#include "tests/training/training_testing.h"
#include "trainer/choose/pilot.h"
#include "trainer/choose/readout_probe.h"
#include "trainer/data/log_files.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/learn/training/readout_rows.h"
#include "trainer/learn/training/train.h"

namespace nlo::trainer {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// y varies slightly about a level that differs between logs, and "grip" is 1 or -1, alternating from log to log. The
/// level determines grip on these logs, but on no other log.
Dataset logs_with_a_level_each(int logs, unsigned seed) {
  Dataset data = testing::harmonics(std::vector<int>(static_cast<std::size_t>(logs), 80), false, seed);
  data.states = {{"position", "m", 0.0}, {"grip", "", 0.0}};
  for (int i = 0; i < logs; ++i) {
    Trajectory& run = data.trajectories[static_cast<std::size_t>(i)];
    run.log = "logs/day_" + std::to_string(i) + ".csv";
    run.source = run.log;
    run.outputs = 0.2 * run.outputs.array() + 3.0 * i;
    run.states.row(0) = run.outputs.row(0);
    run.states.row(1).setConstant(i % 2 == 0 ? 1.0 : -1.0);
  }
  return data;
}

Experiment experiment_of_logs(int folds) {
  Experiment experiment = testing::small_experiment();
  experiment.plant.reset();
  experiment.log.emplace().train_files = {"day_*.csv"};
  experiment.observer.eigenvalues = {-1.0, -4.0};
  experiment.observer.start = LatentStart::kSteady;
  experiment.inverse_map.hidden = {24, 24};
  experiment.inverse_map.readout = ReadoutChoice::kSelected;
  experiment.loss.scale = ErrorScale::kNormalised;
  experiment.training.steps = 4000;
  experiment.training.learning_rate = 1e-2;
  experiment.training.samples_per_step = 512;
  experiment.validation.folds = folds;
  experiment.source_text = format_experiment(experiment);
  return experiment;
}

TEST(StateSquares, BlendOfTwoIndependentErrorsHasHalfTheirVariance) {
  StateSquares squares;
  squares.map = 1.0;
  squares.row = {1.0, 1.0, 4.0};
  squares.both = {0.0, -1.0, 2.0};  // independent; opposite; the row's error is twice that of T*
  EXPECT_DOUBLE_EQ(squares.blend(0, 0.5), 0.5);
  EXPECT_DOUBLE_EQ(squares.blend(1, 0.5), 0.0);
  EXPECT_DOUBLE_EQ(squares.blend(2, 1.0), squares.map);
  EXPECT_DOUBLE_EQ(squares.blend(2, 0.0), squares.row[2]);
}

TEST(Fallback, IsWrittenBesideTheNetworkWithoutChangingOtherStates) {
  codegen::Model model;
  model.structure = codegen::Kkl{};
  model.initial_latent = Eigen::VectorXd::Zero(1);
  model.outputs = {{"y", "m"}};
  model.states = {{"a", "m"}, {"b", "m"}};
  codegen::Network& map = *codegen::inverse_map(model);
  map.features = Eigen::RowVector2d(1.0, 0.0);
  map.feature_mean = Eigen::VectorXd::Zero(1);
  map.feature_scale = map.feature_mean.array() + 1.0;
  map.layers = {{Eigen::MatrixXd::Ones(3, 1), Eigen::VectorXd::Zero(3)},
                {Eigen::MatrixXd::Ones(2, 3), Eigen::VectorXd::Zero(2)}};
  map.output_mean = Eigen::VectorXd::Zero(2);
  map.output_scale = map.output_mean.array() + 1.0;
  SampledTruth samples;
  samples.z = Eigen::RowVector3d(0.1, 0.2, 0.3);
  samples.y = samples.z;
  const RowInputs inputs(model, samples);
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(2, 1 + inputs.all());
  rows(1, 0) = 0.5;
  rows(1, 1) = 2.0;
  const codegen::Network before = map;
  write_readout(map, inputs, Eigen::Vector2d(1.0, 1.0), Eigen::Vector2d(0.0, 0.7), rows, false, true);
  EXPECT_THAT(map.fallback.outputs, ElementsAre(1));
  EXPECT_EQ(map.fallback.offset(0), 0.5);
  EXPECT_EQ(map.fallback.rows(0, 0), 2.0);
  EXPECT_EQ(map.fallback.reach(0), 0.7);
  EXPECT_EQ(map.layers.back().weights, before.layers.back().weights) << "the network is as trained";
  EXPECT_EQ(map.skip.size(), 0);
}

TEST(Fallback, IsChosenIfErrorsOnLeftOutLogsAreFivePercentSmaller) {
  Experiment experiment = testing::small_experiment();
  experiment.inverse_map.readout = ReadoutChoice::kSelected;
  experiment.inverse_map.fallback = true;
  experiment.training.steps = 3;
  const Dataset training = testing::harmonics({40, 60, 33, 50}, false, 1), others = testing::harmonics({50}, false, 2);
  TrainOptions options;
  options.left_out = {{"", others}};
  LeftOutGroup group = train(experiment, training, others, options).left_out.at(0);
  // T* has an error of 1 on left-out logs, rows have 2, and no blend is better. The error with a fallback is given.
  const auto set = [](SetSquares& all, double with_fallback) {
    for (StateSquares& state : all) {
      state.map = state.deviation = 1.0;
      std::ranges::fill(state.row, 4.0);
      std::ranges::fill(state.both, 1.0);
      for (auto& squares : state.fallback) squares.fill(with_fallback * with_fallback);
    }
  };
  const auto trained = [&](double with_fallback) {
    set(group.squares.all, with_fallback);
    for (SetSquares& window : group.squares.windows) set(window, with_fallback);
    TrainOptions chosen;
    chosen.evidence = {group, group};
    return train(experiment, training, others, chosen);
  };
  const TrainingResult better = trained(0.94), alike = trained(0.96);
  EXPECT_THAT(codegen::inverse_map(better.model)->fallback.outputs, ElementsAre(0, 1));
  EXPECT_NEAR(better.readout[0].shipped, 0.94, 1e-9) << "rounding of a geometric mean";
  EXPECT_EQ(better.readout[0].share, 1.0);
  EXPECT_TRUE(codegen::inverse_map(alike.model)->fallback.outputs.empty());
  EXPECT_EQ(alike.readout[0].reach, 0.0);
  experiment.inverse_map.fallback = false;
  EXPECT_TRUE(codegen::inverse_map(trained(0.5).model)->fallback.outputs.empty())
      << "only if the experiment sets fallback";
}

/// Each log has its own constant level. The state "grip" is the level, plus a ripple if |level| < 1. A network that is
/// trained on such levels knows the ripple; at larger levels only a linear row is right.
Dataset logs_with_ripple(const std::vector<double>& levels) {
  Dataset data = logs_with_a_level_each(static_cast<int>(levels.size()), 1);
  for (std::size_t i = 0; i < levels.size(); ++i) {
    Trajectory& run = data.trajectories[i];
    run.outputs.setConstant(levels[i]);
    run.states.row(0) = run.outputs.row(0);
    run.states.row(1).setConstant(levels[i] + (std::abs(levels[i]) < 1.0 ? 0.3 * std::cos(6.0 * levels[i]) : 0.0));
  }
  return data;
}

TEST(Fallback, IsChosenOnlyIfTheNetworkIsWrongOutsideItsLogs) {
  std::vector<double> levels;
  for (int i = -19; i <= 19; ++i) levels.push_back(0.05 * i);
  const Dataset training = logs_with_ripple(levels);
  const auto trained = [&](const std::vector<double>& left_out) {
    TrainOptions options;
    options.left_out = {{"", logs_with_ripple(left_out)}};
    Experiment experiment = experiment_of_logs(0);
    experiment.inverse_map.fallback = true;
    return train(experiment, training, training, options);
  };
  const std::vector<double> inside = {-0.93, -0.57, -0.22, 0.02, 0.38, 0.78}, beyond = {-0.93, -0.22, 0.38, 2.5, -2.5};
  const TrainingResult wrong = trained(beyond), right = trained(inside);
  const StateReadout &helped = wrong.readout[1], &plain = right.readout[1];
  EXPECT_GT(helped.trained, 0.5) << "control: the network is wrong at levels of 2.5";
  EXPECT_GT(helped.reach, 0.0);
  EXPECT_LE(helped.shipped, 0.95 * std::min(helped.trained, helped.linear));
  EXPECT_LT(plain.trained, 0.5 * plain.linear) << "control: within its levels the network is right";
  EXPECT_EQ(plain.reach, 0.0);
  EXPECT_EQ(plain.share, 1.0);
  const Dataset far = logs_with_ripple({2.5});
  EXPECT_LT(testing::reference_rmse(wrong.model, far), 0.5 * testing::reference_rmse(right.model, far))
      << "the choice is in the model";
}

TEST(Folds, EachLogIsLeftOutOnceAndNeighboursAreInDifferentFolds) {
  const Dataset training = logs_with_a_level_each(5, 1);
  const std::vector<FoldOfLogs> folds = folds_of_logs(experiment_of_logs(2), training);
  ASSERT_EQ(folds.size(), 2U);
  EXPECT_THAT(folds[0].names, ElementsAre("day_0.csv", "day_2.csv", "day_4.csv"));
  EXPECT_THAT(folds[1].names, ElementsAre("day_1.csv", "day_3.csv"));
  for (const FoldOfLogs& fold : folds) {
    std::set<std::string> kept, out;
    for (const Trajectory& run : fold.kept.trajectories) kept.insert(run.log);
    for (const LeftOutLogs& group : fold.left_out)
      for (const Trajectory& run : group.logs.trajectories) out.insert(run.log);
    EXPECT_EQ(kept.size() + out.size(), 5U);
    for (const std::string& log : out) EXPECT_EQ(kept.count(log), 0U) << log;
  }
  EXPECT_EQ(folds_of_logs(experiment_of_logs(50), training).size(), 5U) << "at most one fold per log";
}

/// The logs of logs_with_a_level_each() with other names.
Dataset logs_named(const std::vector<std::string>& names) {
  Dataset data = logs_with_a_level_each(static_cast<int>(names.size()), 1);
  for (std::size_t i = 0; i < names.size(); ++i) data.trajectories[i].log = names[i] + ".csv";
  return data;
}

TEST(LogKind, IsTheNameWithoutItsCounter) {
  EXPECT_EQ(log_kind("rubber_07.csv"), "rubber");
  EXPECT_EQ(log_kind("01_fast_A.csv"), "fast_A");
  EXPECT_EQ(log_kind("0degC_Mixed2.csv"), "0degC_Mixed") << "a leading 0 is not a counter";
  EXPECT_EQ(log_kind("17.csv"), "");
  EXPECT_EQ(log_kind("2026-11-20_2.csv"), "11-20");
  EXPECT_EQ(log_kind("chirp"), "chirp");
}

TEST(Folds, ASmallKindIsLeftOutWholeAndTheLargestIsSpreadOverFolds) {
  const Dataset logs = logs_named({"free_1", "rubber_1", "rubber_2", "rubber_3", "rubber_4", "ice_1", "ice_2"});
  const std::vector<FoldOfLogs> folds = folds_of_logs(experiment_of_logs(3), logs);
  ASSERT_EQ(folds.size(), 3U);
  EXPECT_THAT(folds[0].names, ElementsAre("rubber_1.csv", "rubber_4.csv"));
  EXPECT_THAT(folds[1].names, ElementsAre("ice_1.csv", "ice_2.csv", "rubber_2.csv"));
  EXPECT_THAT(folds[2].names, ElementsAre("free_1.csv", "rubber_3.csv"));
  EXPECT_EQ(folds[1].left_out.front().kind, "ice");
}

TEST(LeftOut, EachKindHasTheSameWeightForAnyNumberOfLogs) {
  // On eight logs a linear function of y estimates the grip. On the third and the eighth log it is far off, and the
  // mean is better.
  const auto result_of = [](const std::string& third, const std::string& eighth) {
    Dataset logs = logs_named({"rubber_0", "rubber_1", third, "rubber_3", "rubber_4", "rubber_5", "rubber_6", eighth,
                               "rubber_8", "rubber_9"});
    for (std::size_t i = 0; i < logs.trajectories.size(); ++i) {
      Trajectory& run = logs.trajectories[i];
      run.outputs = run.outputs.array() - 13.5;  // levels from -13.5 to 13.5
      run.states.row(0) = run.outputs.row(0);
      run.states.row(1) = 0.1 * run.outputs.row(0);
      if (i == 2 || i == 7) run.states.row(1).setConstant(0.1);
    }
    Experiment experiment = experiment_of_logs(4);
    experiment.training.steps = 20;
    return train_with_folds(experiment, logs, logs, {}).readout.at(1);
  };
  const StateReadout by_kinds = result_of("ice_2", "sand_7"), by_logs = result_of("rubber_2", "rubber_7");
  EXPECT_EQ(by_kinds.linear, by_kinds.constant) << "for two of three kinds the mean is better";
  EXPECT_LT(by_logs.linear, 0.9 * by_logs.constant) << "control: for eight of ten logs the linear function is better";
}

TEST(Folds, LogsOfOneGroupAreLeftOutTogether) {
  Experiment experiment = experiment_of_logs(4);
  experiment.validation.groups = "^day_([0-3])?";
  const std::vector<FoldOfLogs> folds = folds_of_logs(experiment, logs_with_a_level_each(6, 1));
  ASSERT_EQ(folds.size(), 4U);  // logs 0, 1, 2, 3 and the others: five groups
  EXPECT_EQ(folds[3].left_out.front().logs.trajectories.size(), 2U)
      << "the pattern finds the same text, none, in day_4 and day_5";
  experiment.validation.groups = "^night";
  EXPECT_THAT([&] { folds_of_logs(experiment, logs_with_a_level_each(3, 1)); },
              ::testing::ThrowsMessage<codegen::Error>(HasSubstr("[validation] groups ^night: finds nothing in")));
}

/// One log, where nothing determines the grip.
Dataset single_log_of_chance() {
  Dataset log = logs_with_a_level_each(1, 1);
  std::mt19937 engine(5);
  std::normal_distribution<double> normal;
  log.states = {{"grip", "", 0.0}};
  Eigen::MatrixXd& states = log.trajectories.front().states;
  states.resize(1, states.cols());
  for (double& grip : states.reshaped()) grip = normal(engine);
  return log;
}

TEST(Folds, EachQuarterOfASingleLogIsLeftOutOnce) {
  const Dataset log = logs_with_a_level_each(1, 1);
  Experiment experiment = experiment_of_logs(4);
  const std::vector<FoldOfLogs> folds = folds_of_logs(experiment, log);
  ASSERT_EQ(folds.size(), 4U);
  EXPECT_THAT(folds[1].names, ElementsAre("part 2 of day_0.csv"));
  Eigen::VectorXd left_out = Eigen::VectorXd::Zero(80);
  for (const FoldOfLogs& fold : folds) {
    const Eigen::VectorXd& out = fold.left_out.front().logs.trajectories.front().weight;
    EXPECT_EQ(out.sum(), 20.0);
    EXPECT_EQ((out + fold.kept.trajectories.front().weight), Eigen::VectorXd::Ones(80));
    left_out += out;
  }
  EXPECT_EQ(left_out, Eigen::VectorXd::Ones(80));
  Dataset masked = log;
  masked.trajectories.front().weight.tail(60).setZero();
  EXPECT_TRUE(folds_of_logs(experiment, masked).empty()) << "the other parts have no truth";
  experiment.log->validation_files = {"another_day.csv"};
  EXPECT_TRUE(folds_of_logs(experiment, log).empty()) << "validation data chooses";
}

TEST(SingleLog, IsNotJudgedByTheErrorOfItsOwnTraining) {
  // The deviation of the grip is 1. A function fitted to its 80 samples is close to them, but not to other samples.
  const Dataset log = single_log_of_chance();
  const Experiment experiment = experiment_of_logs(4);
  constexpr double kNearlyOne = 0.8, kHalf = 0.5;
  EXPECT_GT(ReadoutProbe(experiment, log).error(experiment, 64, 4000).curved[0], kNearlyOne);
  EXPECT_GT(Pilots(experiment, log, log, 0.0).error(experiment, 1000), kNearlyOne);
  TrainOptions options;
  options.settled_from_s = log.longest_s() / 2.0;
  EXPECT_LT(train(experiment, log, log, options).split.both(), kHalf) << "control: it can be overfitted";
}

TEST(Folds, NoLogIsLeftOutIfThereIsNothingToChoose) {
  const Dataset training = logs_with_a_level_each(4, 1);
  EXPECT_TRUE(folds_of_logs(experiment_of_logs(0), training).empty());
  Experiment network = experiment_of_logs(4);
  network.inverse_map.readout = ReadoutChoice::kNetwork;
  EXPECT_TRUE(folds_of_logs(network, training).empty());
  EXPECT_TRUE(folds_of_logs(experiment_of_logs(4), logs_with_a_level_each(2, 1)).empty());
}

TEST(LeftOut, AnOverfittedNetworkIsNotUsed) {
  const Dataset training = logs_with_a_level_each(6, 1);
  const TrainingResult by_its_own = train_with_folds(experiment_of_logs(0), training, training, {});
  const TrainingResult by_groups = train_with_folds(experiment_of_logs(3), training, training, {});
  ASSERT_EQ(by_groups.readout.size(), 2U);
  EXPECT_GT(by_its_own.readout[1].share, 0.8) << "control: on its own logs the network is accurate";
  EXPECT_LT(by_its_own.readout[1].shipped, 0.5);
  EXPECT_LT(by_groups.readout[1].share, 0.2);
  EXPECT_GT(by_groups.readout[1].trained, 1.0) << "the result has the error of the network on other logs";
  EXPECT_LE(by_groups.readout[1].shipped, 1.02 * by_groups.readout[1].constant);
  EXPECT_EQ(by_groups.groups, 6U);
  EXPECT_LT(by_groups.readout[0].shipped, 0.1) << "control: a state that generalises keeps its readout";
}

/// "grip" is a smooth function of the level plus or minus .3, alternating from log to log. A network can learn this by
/// heart on its own logs, but not for others.
Dataset logs_off_by_a_bias_each(int logs, unsigned seed) {
  Dataset data = logs_with_a_level_each(logs, 1);
  std::mt19937_64 random(seed);
  for (int i = 0; i < logs; ++i) {
    Trajectory& run = data.trajectories[static_cast<std::size_t>(i)];
    run.outputs.array() -= 2.5 * i;  // levels half a unit apart: half a period of the function
    run.states.row(1).setConstant(std::sin(0.5 * i) + (random() % 2 == 0 ? 0.3 : -0.3));
  }
  return data;
}

TEST(LeftOut, IntervalsHoldOnUnseenLogs) {
  const Dataset training = logs_off_by_a_bias_each(8, 1);
  const auto coverage = [&](int folds) {
    Experiment experiment = experiment_of_logs(folds);
    experiment.inverse_map.error = true;
    TrainOptions options;
    options.left_out = {{"day", logs_off_by_a_bias_each(8, 2)}};
    const TrainingResult result = train_with_folds(experiment, training, training, options);
    const auto ratios = result.left_out.at(0).scores.ratios.row(1).array();
    return static_cast<double>((ratios <= result.model.error->factor_95(1)).count()) /
           static_cast<double>(ratios.size());
  };
  EXPECT_LT(coverage(0), 0.8) << "control: an interval calibrated on its own logs is too narrow for others";
  EXPECT_GE(coverage(4), 0.9);
}

TEST(LeftOut, AnInterruptedRunContinuesToTheSameBytesAndLeavesNoFolders) {
  const Dataset training = logs_with_a_level_each(4, 1);
  Experiment experiment = experiment_of_logs(2);
  experiment.training.steps = 40;
  experiment.training.validate_every = 10;
  const ScratchDirectory whole, pieces;
  TrainOptions options;
  options.directory = whole.path();
  const TrainingResult expected = train_with_folds(experiment, training, training, options);
  // Number of steps before each interruption: in the first fold, in the second, in the training on all logs.
  for (const int after : {5, 18, 25}) {
    std::atomic<bool> stop = false;
    int done = 0;
    options.directory = pieces.path();
    options.resume = after != 5;
    options.stop = &stop;
    options.progress = [&](const TrainProgress&) { stop = ++done >= after; };
    const TrainingResult piece = train_with_folds(experiment, training, training, options);
    ASSERT_EQ(piece.outcome, TrainOutcome::kInterrupted) << after;
    EXPECT_TRUE(folds_have_begun(pieces.path()));
  }
  options.resume = true;
  options.stop = nullptr;
  options.progress = {};
  const TrainingResult resumed = train_with_folds(experiment, training, training, options);
  EXPECT_EQ(codegen::to_json(resumed.model), codegen::to_json(expected.model));
  EXPECT_FALSE(folds_have_begun(pieces.path()));
}

TEST(LeftOut, CheckpointsOfAnotherRunAreNotUsed) {
  const Dataset training = logs_with_a_level_each(4, 1);
  const ScratchDirectory directory, clean;
  const auto run = [&](const ScratchDirectory& in, int steps, int after, bool resume) {
    Experiment experiment = experiment_of_logs(2);
    experiment.training.steps = steps;
    experiment.source_text = format_experiment(experiment);
    std::atomic<bool> stop = false;
    int done = 0;
    TrainOptions options;
    options.directory = in.path();
    options.resume = resume;
    options.stop = &stop;
    options.progress = [&](const TrainProgress&) { stop = ++done >= after; };
    return train_with_folds(experiment, training, training, options);
  };
  constexpr int kNever = 1000;
  ASSERT_EQ(run(directory, 40, 45, false).outcome, TrainOutcome::kInterrupted) << "on all logs, after both folds";
  ASSERT_EQ(run(directory, 60, 5, false).outcome, TrainOutcome::kInterrupted) << "a longer training, in the first fold";
  const TrainingResult resumed = run(directory, 60, kNever, true);
  EXPECT_EQ(codegen::to_json(resumed.model), codegen::to_json(run(clean, 60, kNever, false).model));
}

}  // namespace
}  // namespace nlo::trainer
