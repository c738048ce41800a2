// SPDX-License-Identifier: MIT
#include "trainer/rollout/rollout.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <mutex>
#include <random>
#include <vector>

#include "tests/support/mirrored.h"

namespace nlo::trainer {
namespace {

/// One log of 5,000 samples whose clock jitters by 0.2 %, with some missing samples.
Dataset jittering_log() {
  constexpr int kSamples = 5000;
  std::mt19937 engine(5);
  std::normal_distribution<double> jitter(0.0, 0.002);
  Trajectory run;
  run.source = "log.csv";
  run.time_s.resize(kSamples);
  double t = 0.0;
  for (int k = 0; k < kSamples; ++k) {
    run.time_s[k] = t;
    t += 0.004 * (1.0 + std::clamp(jitter(engine), -0.01, 0.01) + (k % 700 == 699 ? 1.0 : 0.0));
  }
  run.outputs = run.states = Eigen::MatrixXd::Zero(1, kSamples);
  run.weight = Eigen::VectorXd::Ones(kSamples);
  Dataset data;
  data.outputs = {{"y", "", 0.0}};
  data.states = {{"x", "", 0.0}};
  data.sample_period_s = 0.004;
  data.uniform = false;
  data.trajectories = {run};
  return data;
}

TEST(TrainingData, KeepsEachDistinctStepOnce) {
  const Dataset dataset = jittering_log();
  const TrainingData data(dataset);
  // Jitter of +-1 % in grains of 1/16384, around one period and around two.
  EXPECT_LE(data.steps_s.size(), 2U * 329U);
  EXPECT_GT(data.steps_s.size(), 100U);  // control: the steps do jitter
  const Eigen::VectorXd& time_s = dataset.trajectories[0].time_s;
  double end_s = 0.0;
  for (int k = 0; k + 1 < data.runs[0].samples; ++k) {
    const double step_s = data.steps_s[static_cast<std::size_t>(data.runs[0].step_of[static_cast<std::size_t>(k)])];
    ASSERT_NEAR(step_s, time_s[k + 1] - time_s[k], 1.001 * 0.004 / 32768) << k;  // half a grain
    end_s += step_s;
  }
  EXPECT_NEAR(end_s, time_s[time_s.size() - 1], 0.004);  // 5,000 rounding errors do not add up to a drift
}

TEST(TrainingData, HasOneStepWhenSamplingIsUniform) {
  Dataset dataset = jittering_log();
  dataset.uniform = true;
  const TrainingData data(dataset);
  ASSERT_EQ(data.steps_s.size(), 1U);
  EXPECT_EQ(data.steps_s[0], 0.004);
  EXPECT_TRUE(data.runs[0].step_of.empty());
}

TEST(TrainingData, RollsALongRunOutInEightPiecesThatCoverItOnce) {
  Dataset dataset = jittering_log();
  dataset.uniform = true;
  Trajectory& run = dataset.trajectories[0];
  for (const int samples : {kLongestWhole, kLongestWhole + 1}) {
    run.time_s = Eigen::VectorXd::LinSpaced(samples, 0.0, 0.004 * (samples - 1));
    run.outputs = run.states = Eigen::MatrixXd::Zero(1, samples);
    run.weight = Eigen::VectorXd::Ones(samples);
    const std::vector<Segment> segments = whole_runs(TrainingData(dataset));
    EXPECT_EQ(segments.size(), samples > kLongestWhole ? 8U : 1U);
    int next = 0;
    for (const Segment& segment : segments) {
      EXPECT_EQ(segment.start, next);
      next += segment.length;
    }
    EXPECT_EQ(next, samples);
  }
}

/// z = y: a test reads from z everything that a roll-out gathers.
class Identity final : public LatentDynamics {
 public:
  using LatentDynamics::LatentDynamics;
  void prepare(const float*) override {}
  void forward(SegmentGroup& group, int) override { group.latent = group.readings; }
  void backward(SegmentGroup&, int) override {}
};

TEST(Rollout, ChangesTheSignOfOddChannelsInAMirroredSegment) {
  Dataset dataset = jittering_log();
  dataset.outputs.push_back({"even", "", 0.0});
  dataset.states.push_back({"even", "", 0.0});
  Trajectory& run = dataset.trajectories[0];
  run.outputs = run.states = Eigen::MatrixXd::Random(2, run.samples());
  const TrainingData data(testing::mirrored(dataset, {"even"}));
  Rollout rollout(data);
  Identity dynamics(2);
  ThreadPool pool(1);
  std::vector<Segment> segments = {{.run = 0, .start = 7, .length = 20}};
  segments.push_back(segments[0]);
  segments[1].mirrored = true;
  rollout.run(segments, dynamics, {}, 1, Purpose::kSegments, 0, pool);
  const SegmentGroup& group = rollout.groups()[0];
  for (int t = 0; t < 20; ++t) {
    for (int row = 0; row < 2; ++row) {
      const float* lanes = group.readings.data() + group.at(row, t);
      ASSERT_EQ(lanes[0], static_cast<float>(run.outputs(row, 7 + t)));
      ASSERT_EQ(lanes[1], row == 0 ? -lanes[0] : lanes[0]);
      const auto state = static_cast<std::size_t>(row);
      ASSERT_EQ(rollout.state(segments[1], state, t), (row == 0 ? -1.0F : 1.0F) * rollout.state(segments[0], state, t));
    }
  }
}

/// z of all samples of the segments.
using Latents = std::map<std::array<int, 3>, std::vector<float>>;  // z by group, time and lane

void keep_latents(int index, int first, const SegmentGroup& piece, int rows, Latents& all) {
  for (int t = 0; t < piece.length; ++t)
    for (int lane = 0; lane < kGroup; ++lane)
      for (int row = 0; row < rows; ++row) {
        std::vector<float>& z = all[{index, first + t, lane}];
        z.resize(static_cast<std::size_t>(rows));
        z[static_cast<std::size_t>(row)] = piece.latent[piece.at(row, t) + static_cast<std::size_t>(lane)];
      }
}

TEST(Rollout, HasTheSameBitsIfItIsSplitIntoPieces) {
  Dataset dataset = jittering_log();
  Trajectory& run = dataset.trajectories[0];
  run.outputs = run.states = Eigen::MatrixXd::Random(1, run.samples());
  LatentShape shape;
  shape.modes = {{.pair = true, .row = 0, .reading = 0}, {.row = 2, .reading = 0}, {.row = 3}};
  shape.rows = 4;
  shape.learned = 3;
  shape.starts_steady = true;
  ThreadPool pool(2);
  std::vector<Segment> segments;
  for (int s = 0; s < 11; ++s) segments.push_back({.run = 0, .start = 31 * s, .length = 900 - 7 * s});
  for (const bool uniform : {true, false}) {
    dataset.uniform = uniform;
    const TrainingData data(dataset);
    const std::vector<double> eigenvalues = {-3.0, 8.0, -2.0, -1.0};
    const std::vector<float> parameters = parameters_from_eigenvalues(shape, eigenvalues.data());
    LinearLatent dynamics(shape, eigenvalues, data.steps_s, true);
    dynamics.prepare(parameters.data());
    const NoiseMixture noise(parse_noise("gaussian:0.1"));
    Rollout whole(data), pieces(data);
    whole.run(segments, dynamics, noise, 1, Purpose::kNoise, 0, pool);
    Latents expected, found;
    for (std::size_t g = 0; g < whole.groups().size(); ++g)
      keep_latents(static_cast<int>(g), 0, whole.groups()[g], shape.rows, expected);
    std::mutex one;
    int longest = 0;
    pieces.run_in_pieces(segments, dynamics, noise, 1, Purpose::kNoise, 0, pool, {}, 64,
                         [&](int index, int first, const SegmentGroup& piece) {
                           const std::lock_guard<std::mutex> lock(one);
                           longest = std::max(longest, piece.length);
                           keep_latents(index, first, piece, shape.rows, found);
                         });
    EXPECT_EQ(longest, 64);
    EXPECT_EQ(found, expected);
    EXPECT_GT(expected.size(), 10000U);  // control: there are values to compare
  }
}

TEST(Rollout, DoesNotSplitAGroupWhoseDynamicsCannotContinue) {
  const TrainingData data(jittering_log());
  Rollout rollout(data);
  Identity dynamics(1);
  ThreadPool pool(1);
  std::vector<int> lengths;
  rollout.run_in_pieces({{.run = 0, .start = 0, .length = 900}}, dynamics, {}, 1, Purpose::kNoise, 0, pool, {}, 64,
                        [&](int, int, const SegmentGroup& piece) { lengths.push_back(piece.length); });
  EXPECT_EQ(lengths, std::vector<int>{900});
}

/// Two outputs, the second of which is even.
Dataset mirrored_log() {
  Dataset dataset = jittering_log();
  dataset.outputs = {{"a", "", 0.0}, {"b", "", 0.0}};
  Trajectory& run = dataset.trajectories[0];
  run.outputs = Eigen::MatrixXd::Random(2, run.samples());
  return testing::mirrored(dataset, {"b"});
}

/// Returns the readings of a segment with this noise, and those of its mirror image.
std::pair<Eigen::MatrixXf, Eigen::MatrixXf> with_image(const Dataset& dataset, const std::string& noise) {
  const TrainingData data(dataset);
  Rollout rollout(data);
  Identity dynamics(2);
  ThreadPool pool(1);
  std::vector<Segment> segments = {{.run = 0, .start = 7, .length = 20}};
  segments.push_back(segments[0]);
  segments[1].mirrored = true;
  rollout.run(segments, dynamics, NoiseMixture(parse_noise(noise)), 1, Purpose::kNoise, 0, pool);
  std::pair<Eigen::MatrixXf, Eigen::MatrixXf> both{Eigen::MatrixXf(2, 20), Eigen::MatrixXf(2, 20)};
  for (int row = 0; row < 2; ++row)
    for (int t = 0; t < 20; ++t) {
      const float* lanes = rollout.groups()[0].readings.data() + rollout.groups()[0].at(row, t);
      both.first(row, t) = lanes[0];
      both.second(row, t) = lanes[1];
    }
  return both;
}

TEST(Rollout, AddsTheSensorsNoiseToAMirroredSegment) {
  const Dataset dataset = mirrored_log();
  const Eigen::MatrixXf noisy = with_image(dataset, "gaussian:0.3,none").second,
                        clean = with_image(dataset, "none").second;
  EXPECT_GT((noisy.row(0) - clean.row(0)).cwiseAbs().maxCoeff(), 0.1F);
  EXPECT_EQ(noisy.row(1), clean.row(1)) << "the second sensor has no noise";
}

TEST(Rollout, DelaysTheReadingsOfAMirroredSegment) {
  const Dataset dataset = mirrored_log();
  const auto [plain, image] = with_image(dataset, "none+delay:1.5,none+delay:1.5");
  EXPECT_EQ(image.row(0), -plain.row(0));
  EXPECT_EQ(image.row(1), plain.row(1));
  EXPECT_GT((image - with_image(dataset, "none").second).cwiseAbs().maxCoeff(), 0.1F) << "control";
}

/// Two outputs and an input that is read; the third output is the product of the second and the input.
Dataset log_with_a_product() {
  Dataset dataset = jittering_log();
  dataset.outputs = {{"a", "", 0.0}, {"b", "", 0.0}, {"product", "", 0.0, "2 * b * u"}};
  dataset.inputs = {{"u", "", 0.0}};
  dataset.reads_inputs = true;
  Trajectory& run = dataset.trajectories[0];
  run.outputs = Eigen::MatrixXd::Random(3, run.samples());
  run.inputs = Eigen::MatrixXd::Random(1, run.samples());
  return dataset;
}

TEST(Rollout, ComputesOutputsFromNoisyReadings) {
  const TrainingData data(testing::mirrored(log_with_a_product()));
  Rollout rollout(data);
  Identity dynamics(4);
  ThreadPool pool(1);
  std::vector<Segment> segments = {{.run = 0, .start = 7, .length = 20}};
  segments.push_back(segments[0]);
  segments[1].mirrored = true;
  rollout.run(segments, dynamics, NoiseMixture(parse_noise("gaussian:0.3,uniform:0.2")), 1, Purpose::kSegments, 0, pool,
              parse_noise("gaussian:0.1"));
  const SegmentGroup& group = rollout.groups()[0];
  for (int t = 0; t < 20; ++t)
    for (std::size_t lane = 0; lane < 2; ++lane) {
      const auto at = [&](int row) { return group.readings[group.at(row, t) + lane]; };
      ASSERT_EQ(at(2), 2.0F * at(1) * at(3));
      ASSERT_NE(at(1),
                static_cast<float>(data.runs[0].readings[static_cast<std::size_t>(1 * data.runs[0].samples + 7 + t)]));
    }
}

TEST(Rollout, AComputedOutputIsMissingIfOneOfItsSensorsIs) {
  const codegen::SensorFailures failures{.outputs = {1, 2}, .rest = Eigen::Vector2d(0.5, -0.25), .staleness_s = 1e9};
  const TrainingData data(log_with_a_product(), failures);
  Rollout rollout(data);
  Identity dynamics(6);
  ThreadPool pool(1);
  std::vector<Segment> segments = {{.run = 0, .start = 0, .length = 20}};
  segments[0].outages = {{5, 10}, {15, 18}};  // the second output is computed, so it has no outage of its own
  rollout.run(segments, dynamics, {}, 1, Purpose::kSegments, 0, pool);
  const SegmentGroup& group = rollout.groups()[0];
  for (int t = 0; t < 20; ++t) {
    const auto at = [&](int row) { return group.readings[group.at(row, t)]; };
    const bool missing = t >= 5 && t < 10;
    ASSERT_NEAR(at(2), missing ? group.readings[group.at(2, 4)] : 2.0F * at(1) * at(3),
                1e-6F);               // its time constant is long, so it hardly fades
    ASSERT_NEAR(at(5), 0.0F, 1e-6F);  // its staleness stays near 0 for the same reason
  }
  EXPECT_EQ(runs_with_failures(data, 0.3).size(), data.runs.size());  // each run again with the sensor that may fail
  EXPECT_TRUE(runs_with_failures(data, 0.0).empty()) << "failures that training leaves out do not choose the model";
}

}  // namespace
}  // namespace nlo::trainer
