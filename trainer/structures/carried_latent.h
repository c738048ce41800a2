// SPDX-License-Identifier: MIT
// The latent system of a carried observer (nlo/carried_observer.h) over groups of segments. It transforms y into axes
// that are fixed in the world, filters it there as for a KKL observer, and transforms z back. Rotations are orthogonal,
// so cotangents are transformed in the same way, and the gradients of the eigenvalues are those of the filter.
#pragma once

#include <vector>

#include "trainer/gradients/sensitivity/latent_dynamics.h"

namespace nlo::trainer {

class CarriedLatent final : public LatentDynamics {
 public:
  /// Readings are `outputs` components of vectors, then the three components of the rate. Each output has the same
  /// number of rows of z.
  CarriedLatent(const LatentShape& shape, int outputs, const std::vector<double>& eigenvalues,
                const std::vector<double>& steps_s, bool fixed);

  void prepare(const float* parameters) override { filter_.prepare(parameters); }
  void forward(SegmentGroup& group, int thread) override;
  void backward(SegmentGroup& group, int thread) override;

 private:
  /// Returns, for each sample and lane, the axes of the body relative to those of its first sample.
  std::vector<float> attitudes(const SegmentGroup& group) const;
  /// Rotates vectors, whose components are `stride` rows apart, into the axes of the first sample, or back from them.
  void turn(const SegmentGroup& group, const std::vector<float>& attitudes, bool back, int stride,
            std::vector<float>& signal) const;

  LinearLatent filter_;
  int outputs_;
  bool command_;  ///< true: the rate of a sample has acted since the previous sample
  const std::vector<double>& steps_s_;
};

}  // namespace nlo::trainer
