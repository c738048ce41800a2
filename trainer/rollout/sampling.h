// SPDX-License-Identifier: MIT
// Which parts of the trajectories a training step sees: segments to roll out, and the samples of them at which the
// estimate is compared with the truth.
#pragma once

#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/rollout/rollout.h"

namespace nlo::trainer {

/// Returns true if every segment of the training begins where its run does, at full length.
bool trains_whole_runs(const TrainingConfig& training);

/// Draws the segments of a step: whole runs (full_batch) or random segments, mirrored at random and with a noise level
/// as configured.
std::vector<Segment> draw_segments(const Experiment& experiment, const TrainingData& data, long step);

/// The segments that scales and the domain come from: every run from its first sample, its mirror image, and a draw of
/// the segments that training starts anywhere else.
std::vector<Segment> flight_segments(const Experiment& experiment, const TrainingData& data);

/// Samples of one group, in the order of time; a sample that was drawn twice counts twice.
struct SampleSet {
  std::vector<int> offsets;  ///< time * 8 + lane
  std::vector<float> weights;
  double total_weight = 0.0;
};

/// A step's own draw for each group of a rollout, or `all` samples. Masked ones are left out.
std::vector<SampleSet> draw_samples(const Experiment& experiment, const Rollout& rollout, long step, bool all,
                                    ThreadPool& pool);

}  // namespace nlo::trainer
