// SPDX-License-Identifier: MIT
// Chooses the parts of the trajectories that a training step uses: segments to roll out, and their samples at which the
// estimate is compared with the truth.
#pragma once

#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/rollout/rollout.h"

namespace nlo::trainer {

/// Returns true if every segment of the training begins at the start of its run, at full length.
bool trains_whole_runs(const TrainingConfig& training);

/// Draws the segments of a step: whole runs (full_batch) or random segments, mirrored at random and with a noise level
/// as configured.
std::vector<Segment> draw_segments(const Experiment& experiment, const TrainingData& data, long step);

/// Returns the segments from which scales and the domain are computed: every run from its first sample, its mirror
/// image, and a random sample of the segments that training starts later in a run.
std::vector<Segment> flight_segments(const Experiment& experiment, const TrainingData& data);

/// Samples of one group, in the order of time; a sample that was drawn twice counts twice.
struct SampleSet {
  std::vector<int> offsets;  ///< time * 8 + lane
  std::vector<float> weights;
  double total_weight = 0.0;
};

/// Returns the samples of a step for each group of a rollout, or all samples if `all` is true. Masked samples are left
/// out.
std::vector<SampleSet> draw_samples(const Experiment& experiment, const Rollout& rollout, long step, bool all,
                                    ThreadPool& pool);

}  // namespace nlo::trainer
