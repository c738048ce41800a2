// SPDX-License-Identifier: MIT
// Copies the samples of a block row by row into the form that the losses of T read.
#pragma once

#include <vector>

#include "trainer/learn/losses/estimate_block.h"
#include "trainer/learn/losses/map_block.h"

namespace nlo::trainer {

class SampleRows {
 public:
  explicit SampleRows(const ObserverStructure& structure);

  /// Copies x, z, y and h of a rollout's samples, and f if the data has it. Weights are multiplied by `share`.
  MapSamples<float> gather(const Rollout& rollout, const SampleRange& samples, float share, bool with_equations);
  /// Copies x, f and h of collocation points [first, first + count). Each point gets the weight `weight`.
  MapSamples<float> gather(const TrainingData::Points& points, int first, int count, float weight);

  /// Adds `cotangent` (n_z rows) to the cotangents of the samples in the rollout.
  static void scatter(const std::vector<float>& cotangent, const SampleRange& samples, Rollout& rollout);

 private:
  MapSamples<float> view(int count) const;

  std::vector<float> x_, z_, y_, f_, h_, weight_;
};

}  // namespace nlo::trainer
