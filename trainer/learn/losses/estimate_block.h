// SPDX-License-Identifier: MIT
// Compares the estimates at a block of samples with the truth, for losses of x_hat. Either T* reads z and y through its
// features, or z itself is the estimate.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "trainer/gradients/nn/network_block.h"
#include "trainer/rollout/rollout.h"
#include "trainer/rollout/sampling.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// Samples [first, first + count) of a group's set.
struct SampleRange {
  const SampleSet* set = nullptr;
  int group = 0, first = 0, count = 0;

  const int* offsets() const { return set->offsets.data() + first; }
  const float* weights() const { return set->weights.data() + first; }
};

class EstimateBlock {
 public:
  /// `structure` must outlive this object. Its means and scales may still change until the first block.
  explicit EstimateBlock(const ObserverStructure& structure, bool normalised);

  /// Runs T* at these samples and compares its estimates with the truth. error() and squares() refer to these samples
  /// until the next call.
  ///   parameters  of T*
  void evaluate(Rollout& rollout, const SampleRange& samples, const float* parameters);
  /// Propagates the cotangents of the losses back through T* into the group's cotangent of z.
  void backward(const float* parameters, const float* transposed);

  std::size_t states() const { return structure_->state_scale.size(); }
  int count() const { return samples_.count; }
  const float* weights() const { return samples_.weights(); }
  const float* error(std::size_t state) const { return error_.data() + state * kRow; }  ///< x_hat - x
  /// Returns 1 / scale^2 if squared errors are normalised, else 1.
  float per_unit(std::size_t state) const;
  /// Returns the sum of weight error^2 / unit^2 over the block.
  double squares(std::size_t state) const { return squares_[state]; }

  /// Adds of(sample, gain) to the cotangent of the output of T* (or of z). `gain` is the derivative of x_hat with
  /// respect to this output.
  template <class Cotangent>
  void pull_back(std::size_t state, const Cotangent& of) {
    if (has_network()) {
      float* to = network_->output_cotangent() + state * kRow;
      const float gain = structure_->state_scale[state];
      for (int s = 0; s < samples_.count; ++s) to[s] += of(s, gain);
    } else {
      SegmentGroup& group = rollout_->groups()[static_cast<std::size_t>(samples_.group)];
      float* to = group.cotangent.data() + group.at(static_cast<int>(state), 0);
      const int* offsets = samples_.offsets();
      for (int s = 0; s < samples_.count; ++s) to[offsets[s]] += of(s, 1.0F);
    }
  }

  void clear_gradient();
  /// Writes the gradient of T*. Does nothing if there is no T*.
  void gradient(float* out) const;

 private:
  bool has_network() const { return network_.has_value(); }
  void read_features();
  void pull_back_features();

  const ObserverStructure* structure_;
  bool normalised_;
  Rollout* rollout_ = nullptr;
  SampleRange samples_;
  std::optional<WideBlock> network_;  // T*; empty if z is the estimate
  std::vector<float> error_;          // n_x rows
  std::vector<double> squares_;       // n_x
};

}  // namespace nlo::trainer
