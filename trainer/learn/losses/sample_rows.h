// SPDX-License-Identifier: MIT
// Copies of a block of samples, row by row, as the losses of T read them.
#pragma once

#include <vector>

#include "trainer/learn/losses/estimate_block.h"
#include "trainer/learn/losses/map_block.h"

namespace nlo::trainer {

class SampleRows {
 public:
  explicit SampleRows(const ObserverStructure& structure);

  /// x, z, y and h of a rollout's samples; f too where the data has it. Weights are times `share`.
  MapSamples<float> gather(const Rollout& rollout, const SampleRange& samples, float share, bool with_equations);
  /// x, f and h of collocation points [first, first + count), each of that weight.
  MapSamples<float> gather(const TrainingData::Points& points, int first, int count, float weight);

  /// Adds `cotangent` (n_z rows) to the samples' cotangents in the rollout.
  static void scatter(const std::vector<float>& cotangent, const SampleRange& samples, Rollout& rollout);

 private:
  MapSamples<float> view(int count) const;

  std::vector<float> x_, z_, y_, f_, h_, weight_;
};

}  // namespace nlo::trainer
