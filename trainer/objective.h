// SPDX-License-Identifier: MIT
// The state error (12) of a KKL observer over sampled trajectories, and its exact gradient: filter the segments, run T*
// over blocks of samples, pull the cotangents of z back through the adjoint filter. One route for full batches and
// random samples; they differ in which segments and ticks are drawn.
#pragma once

#include <vector>

#include "trainer/config.h"
#include "trainer/rollout.h"
#include "trainer/structures/kkl.h"

namespace nlo::trainer {

/// Mean squared error over the samples used: as it is minimised, and in the states' units as a root.
struct ObjectiveValue {
  double loss = 0.0;
  double rmse = 0.0;  ///< sqrt(mean |x - x_hat|^2)
};

class Objective {
 public:
  Objective(const Experiment& experiment, const KklStructure& structure, const TrainingData& data, ThreadPool& pool);

  /// Loss and gradient at a step's own draw of segments, noise and ticks.
  ///   gradient  n parameters, or null for the value alone
  ObjectiveValue evaluate(const float* parameters, long step, float* gradient);

  /// Error over whole runs and all samples, with noise that is the same in every call.
  ObjectiveValue validate(const float* parameters);

  Rollout& rollout() { return rollout_; }
  /// Filters whole runs at these parameters, with noise: for normalisation and for the domain.
  Rollout& filter_all(const float* parameters);

 private:
  /// The samples of one group that T* is evaluated at.
  struct Samples {
    std::vector<int> offsets;  ///< time * 8 + lane
    std::vector<float> weights;
  };
  struct Block {
    int group, first, count;
  };
  struct ChunkResult {
    double loss = 0.0, squares = 0.0;
    std::vector<float> gradient;
  };

  std::vector<Segment> draw_segments(long step) const;
  void draw_samples(long step, bool all);
  void filter_segments(const float* parameters, const std::vector<Segment>& segments, Purpose purpose, long step);
  ObjectiveValue accumulate(const float* parameters, float* gradient);
  void run_block(const Block& block, const float* network, BlockWorkspace& workspace, ChunkResult& result,
                 bool backward);

  const Experiment* experiment_;
  const KklStructure* structure_;
  const TrainingData* data_;
  ThreadPool* pool_;
  Coefficients coefficients_;
  bool coefficients_current_ = false;
  Rollout rollout_;
  std::vector<Samples> samples_;  // one per group
  std::vector<Block> blocks_;
  double total_weight_ = 0.0;
  std::vector<ChunkResult> chunks_;
  std::vector<BlockWorkspace> workspaces_;  // one per thread
  std::vector<float> transposed_;
};

}  // namespace nlo::trainer
