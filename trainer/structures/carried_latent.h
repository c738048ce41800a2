// SPDX-License-Identifier: MIT
// The latent system of a carried observer (nlo/carried_observer.h) over groups of segments. In axes that stand still in
// the world nothing turns: y is taken there, filtered as for a KKL observer, and z comes back. Cotangents go the same
// way, as rotations keep lengths, so gradients of the eigenvalues are the filter's own.
#pragma once

#include <vector>

#include "trainer/gradients/sensitivity/latent_dynamics.h"

namespace nlo::trainer {

class CarriedLatent final : public LatentDynamics {
 public:
  /// Readings are `outputs` components of vectors, then the three of the rate; each output has as many rows of z.
  CarriedLatent(const LatentShape& shape, int outputs, const std::vector<double>& eigenvalues,
                const std::vector<double>& steps_s, bool fixed);

  void prepare(const float* parameters) override { filter_.prepare(parameters); }
  void forward(SegmentGroup& group, int thread) override;
  void backward(SegmentGroup& group, int thread) override;

 private:
  /// For each sample and lane, the axes of the body in the axes of its first sample.
  std::vector<float> attitudes(const SegmentGroup& group) const;
  /// Turns vectors whose components are `stride` rows apart into the axes of the first sample, or back from them.
  void turn(const SegmentGroup& group, const std::vector<float>& attitudes, bool back, int stride,
            std::vector<float>& signal) const;

  LinearLatent filter_;
  int outputs_;
  bool command_;  ///< the rate of a sample has acted since the sample before
  const std::vector<double>& steps_s_;
};

}  // namespace nlo::trainer
