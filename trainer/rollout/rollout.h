// SPDX-License-Identifier: MIT
// Segments of recorded trajectories, disturbed by noise and run through the latent system: what a training step, a
// validation and the normalisation all start from.
#pragma once

#include <cstdint>
#include <vector>

#include "trainer/base/noise.h"
#include "trainer/base/parallel.h"
#include "trainer/base/random.h"
#include "trainer/data/dataset.h"
#include "trainer/sensitivity/latent_dynamics.h"

namespace nlo::trainer {

/// A dataset as training reads it: float32, one row per channel, each distinct step between samples once.
struct TrainingData {
  /// Points of a box with f and h there, row by row: where the PDE residual (5) is asked for beyond the data.
  struct Points {
    int count = 0;
    std::vector<float> x, f, h;
  };
  struct Run {
    int samples = 0;
    int first_estimate = 0;          ///< see Trajectory
    std::vector<int> step_of;        ///< samples: which of steps_s leaves the sample; empty when uniform
    std::vector<float> readings;     ///< n_r x samples: outputs, then the inputs that the observer reads
    std::vector<float> states;       ///< n_x x samples
    std::vector<float> weight;       ///< samples
    std::vector<float> derivatives;  ///< n_x x samples, f(x): filled for the PDE residual only
  };
  std::vector<Run> runs;
  Points collocation;
  /// One entry when uniform; else the distinct steps, to 1/16384 of a period: coefficients are made once for each, and
  /// a log of 20,000 samples whose clock jitters by 1 % has some hundred of them.
  std::vector<double> steps_s;
  double sample_period_s = 0.0;  ///< nominal
  bool uniform = true;
  int nx = 0, ny = 0, nr = 0;
  codegen::SensorFailures failures;  ///< whose stalenesses end the readings; they are made as a segment rolls out
  std::vector<float> fading;         ///< exp(-step / staleness_s) of each of steps_s
  std::vector<EncodedAngle> output_angles;          ///< among the outputs: their noise is on the angle
  std::vector<float> reading_mirror, state_mirror;  ///< nr and nx: what a mirrored segment multiplies them by, -1 or 1

  explicit TrainingData(const Dataset& dataset, const codegen::SensorFailures& failures = {});

  int given() const { return nr - static_cast<int>(failures.outputs.size()); }  ///< readings that the data have
};

/// Samples [from, to) of a segment at which a sensor is missing.
struct Outage {
  int from = 0, to = 0;
};

struct Segment {
  int run = 0;
  int start = 0;
  int length = 0;
  bool mirrored = false;             ///< odd channels have their sign turned
  float noise_level = 1.0F;          ///< times the configured noise
  std::vector<Outage> outages = {};  ///< one for each sensor that may fail; empty: all measure
};

/// All runs from their start, at full length.
std::vector<Segment> whole_runs(const TrainingData& data);

/// The same with one sensor missing throughout, for each that may fail.
std::vector<Segment> runs_with_failures(const TrainingData& data);

class Rollout {
 public:
  explicit Rollout(const TrainingData& data) : data_(&data) {}

  /// Gathers the segments eight to a group, adds noise (streams: seed, purpose, step, group) and runs the prepared
  /// dynamics over them. `noise` has an entry for all of the data's sensors, or one for each; of several noises each group
  /// takes the next. `input_noise` is of the inputs that are read.
  void run(const std::vector<Segment>& segments, LatentDynamics& dynamics, const NoiseMixture& noise, std::uint64_t seed,
           Purpose purpose, std::uint64_t step, ThreadPool& pool, const NoiseConfig& input_noise = {});

  std::vector<SegmentGroup>& groups() { return groups_; }
  const std::vector<SegmentGroup>& groups() const { return groups_; }
  const std::vector<Segment>& segments() const { return segments_; }
  const Segment& segment(int group, int lane) const {
    return segments_[static_cast<std::size_t>(group * kGroup + lane)];
  }
  const TrainingData& data() const { return *data_; }
  /// The truth there, turned where the segment is mirrored.
  float state(const Segment& segment, std::size_t row, int time) const {
    const TrainingData::Run& run = data_->runs[static_cast<std::size_t>(segment.run)];
    return (segment.mirrored ? data_->state_mirror[row] : 1.0F) *
           run.states[row * static_cast<std::size_t>(run.samples) + static_cast<std::size_t>(segment.start + time)];
  }

 private:
  void gather(int index, const NoiseConfig& noise, const NoiseConfig& input_noise, std::uint64_t stream);
  void add_outages(int index);

  void add_noise(SegmentGroup& group, const NoiseConfig& noise, const NoiseConfig& input_noise, const float* level,
                 std::uint64_t stream) const;
  /// Of the sensor at place `sensor` of the outputs, or of the input that is reading `row`.
  const SensorNoise& noise_of(const NoiseConfig& noise, const NoiseConfig& input_noise, int row,
                              std::size_t sensor) const {
    return row < data_->ny ? noise.of(sensor) : input_noise.of(static_cast<std::size_t>(row - data_->ny));
  }

  // sensor_timing.cpp
  void measure_late(int index, const NoiseConfig& noise, const NoiseConfig& input_noise, std::uint64_t stream);
  void lose_samples(int index, const NoiseConfig& noise, const NoiseConfig& input_noise, std::uint64_t stream);
  void shift_row(int index, int row, const SensorNoise& own, const float* delay, const float* clock);
  void hold_row(int index, int row, const SensorNoise& own, const std::vector<float>& draws);

  const TrainingData* data_;
  std::vector<Segment> segments_;
  std::vector<SegmentGroup> groups_;
};

}  // namespace nlo::trainer
