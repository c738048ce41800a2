// SPDX-License-Identifier: MIT
// Segments of recorded trajectories, disturbed by noise and run through the latent system. A training step, a
// validation and the normalisation start from them.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "trainer/base/noise.h"
#include "trainer/base/parallel.h"
#include "trainer/base/random.h"
#include "trainer/gradients/sensitivity/latent_dynamics.h"
#include "trainer/rollout/training_data.h"

namespace nlo::trainer {

class Rollout {
 public:
  explicit Rollout(const TrainingData& data) : data_(&data) {}

  /// Gathers the segments in groups of eight, adds noise (streams: seed, purpose, step, group) and runs the prepared
  /// dynamics over them. A noise has one entry for all sensors of the data, or one for each sensor. If there are
  /// several noises, the groups alternate between them. `input_noise`: noise of the inputs that are read.
  void run(const std::vector<Segment>& segments, LatentDynamics& dynamics, const NoiseMixture& noise,
           std::uint64_t seed, Purpose purpose, std::uint64_t step, ThreadPool& pool,
           const NoiseConfig& input_noise = {});

  /// Visits a piece of a group: visit(index of the group, time of the piece's first sample in the segments, piece).
  using VisitPiece = std::function<void(int index, int first, const SegmentGroup& piece)>;

  /// Computes the same as run() but stores no group: visits each group in pieces, in the order of time. A thread visits
  /// one group at a time. `length`: largest number of samples in a piece. Dynamics that cannot continue have one piece
  /// per group.
  void run_in_pieces(const std::vector<Segment>& segments, LatentDynamics& dynamics, const NoiseMixture& noise,
                     std::uint64_t seed, Purpose purpose, std::uint64_t step, ThreadPool& pool,
                     const NoiseConfig& input_noise, int length, const VisitPiece& visit);

  std::vector<SegmentGroup>& groups() { return groups_; }
  const std::vector<SegmentGroup>& groups() const { return groups_; }
  const std::vector<Segment>& segments() const { return segments_; }
  const Segment& segment(int group, int lane) const {
    return segments_[static_cast<std::size_t>(group * kGroup + lane)];
  }
  const TrainingData& data() const { return *data_; }
  /// Returns the true state at sample `time` of the segment.
  float state(const Segment& segment, std::size_t row, int time) const {
    const float recorded = recorded_states(segment, row)[time];
    return segment.mirrored ? data_->mirror.of_state(row) * recorded : recorded;
  }
  /// Returns the true state from the start of the segment on; null for a mirrored segment.
  const float* recorded(const Segment& segment, std::size_t row) const {
    return segment.mirrored ? nullptr : recorded_states(segment, row);
  }

 private:
  const float* recorded_states(const Segment& segment, std::size_t row) const {
    const TrainingData::Run& run = data_->runs[static_cast<std::size_t>(segment.run)];
    return run.states.data() + row * static_cast<std::size_t>(run.samples) + segment.start;
  }
  /// Gathers the groups and calls `use` with each.
  void gather_all(const std::vector<Segment>& segments, const NoiseMixture& noise, std::uint64_t seed, Purpose purpose,
                  std::uint64_t step, ThreadPool& pool, const NoiseConfig& input_noise,
                  const std::function<void(int index, int thread)>& use);
  void gather(int index, const NoiseConfig& noise, const NoiseConfig& input_noise, std::uint64_t stream);
  void mark_held(int index);
  void lose_failing(int index);
  void compute(SegmentGroup& group) const;
  void fill_missing(int index);
  /// The last value that a slow output with may_fail had before a segment, and the number of samples since then.
  struct LastArrival {
    float y = 0.0F;
    int age = 0;
  };
  LastArrival last_arrival(const Segment& segment, std::size_t failing) const;
  void clamp(SegmentGroup& group) const;

  void add_noise(SegmentGroup& group, const NoiseConfig& noise, const NoiseConfig& input_noise, const float* level,
                 std::uint64_t stream) const;
  /// Returns the noise of sensor `sensor` of the outputs, or of the input that is reading `row`.
  const SensorNoise& noise_of(const NoiseConfig& noise, const NoiseConfig& input_noise, int row,
                              std::size_t sensor) const {
    return row < data_->ny ? noise.of(sensor) : input_noise.of(static_cast<std::size_t>(row - data_->ny));
  }

  // sensor_timing.cpp
  void measure_late(int index, const NoiseConfig& noise, const NoiseConfig& input_noise, std::uint64_t stream);
  void fail_sensors(int index, const NoiseConfig& noise, const NoiseConfig& input_noise, std::uint64_t stream);
  void shift_row(int index, int row, const SensorNoise& own, const float* delay, const float* clock);
  void fail_row(int index, int row, OutageKind kind, const OutageRate& rate, const std::vector<float>& draws,
                float dead);

  const TrainingData* data_;
  ReadingLimits limits_;
  std::vector<Segment> segments_;
  std::vector<SegmentGroup> groups_;
};

}  // namespace nlo::trainer
