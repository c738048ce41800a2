// SPDX-License-Identifier: MIT
#include "trainer/learn/losses/estimate_block.h"

#include <algorithm>

namespace nlo::trainer {

EstimateBlock::EstimateBlock(const ObserverStructure& structure, bool normalised)
    : structure_(&structure),
      normalised_(normalised),
      error_(structure.state_scale.size() * static_cast<std::size_t>(kRow)),
      squares_(structure.state_scale.size()) {
  if (!structure.features.empty()) network_.emplace(structure.network);
}

float EstimateBlock::per_unit(std::size_t state) const {
  const float scale = structure_->state_scale[state];
  return normalised_ ? 1.0F / (scale * scale) : 1.0F;
}

void EstimateBlock::clear_gradient() {
  if (network_) network_->clear_gradient();
}

void EstimateBlock::gradient(float* out) const {
  if (network_) network_->gradient(out);
}

void EstimateBlock::read_features() {
  const SegmentGroup& group = rollout_->groups()[static_cast<std::size_t>(samples_.group)];
  const int* offsets = samples_.offsets();
  const auto& features = structure_->features;
  for (std::size_t f = 0; f < features.size(); ++f) {
    const Feature& feature = features[f];
    const float* z = feature.latent >= 0 ? group.latent.data() + group.at(feature.latent, 0) : nullptr;
    const float* y = feature.reading >= 0 ? group.readings.data() + group.at(feature.reading, 0) : nullptr;
    float* row = network_->input() + f * kRow;
    const FeatureFormula<float> formula(feature);
    for (int s = 0; s < samples_.count; ++s)
      row[s] = formula.normalised(z != nullptr ? z + offsets[s] : nullptr, y != nullptr ? y + offsets[s] : nullptr);
    if (feature.clock >= 0) {
      const float* clock = group.latent.data() + group.at(feature.clock, 0);
      for (int s = 0; s < samples_.count; ++s) row[s] *= clock[offsets[s]];
    }
    std::fill(row + samples_.count, row + kBlock, 0.0F);
  }
}

void EstimateBlock::pull_back_features() {
  SegmentGroup& group = rollout_->groups()[static_cast<std::size_t>(samples_.group)];
  const int* offsets = samples_.offsets();
  const auto& features = structure_->features;
  for (std::size_t f = 0; f < features.size(); ++f) {
    if (features[f].latent < 0) continue;
    float* g = group.cotangent.data() + group.at(features[f].latent, 0);
    const float* du = network_->input_cotangent() + f * kRow;
    const float inverse = FeatureFormula<float>(features[f]).inverse;
    if (features[f].clock >= 0) {  // a clock has no learned parameters; only its factor has a cotangent
      const float* clock = group.latent.data() + group.at(features[f].clock, 0);
      for (int s = 0; s < samples_.count; ++s) g[offsets[s]] += inverse * clock[offsets[s]] * du[s];
      continue;
    }
    for (int s = 0; s < samples_.count; ++s) g[offsets[s]] += inverse * du[s];
  }
}

void EstimateBlock::evaluate(Rollout& rollout, const SampleRange& samples, const float* parameters) {
  rollout_ = &rollout;
  samples_ = samples;
  if (has_network()) {
    read_features();
    network_->forward(parameters);
  }
  const SegmentGroup& group = rollout.groups()[static_cast<std::size_t>(samples.group)];
  const int* offsets = samples.offsets();
  const float* weights = samples.weights();
  for (std::size_t i = 0; i < states(); ++i) {
    const float scale = structure_->state_scale[i], mean = structure_->state_mean[i];
    const float* n = has_network() ? network_->output() + i * kRow : nullptr;
    const float* z = has_network() ? nullptr : group.latent.data() + group.at(static_cast<int>(i), 0);
    float* errors = error_.data() + i * kRow;
    float squares = 0.0F;
    const float* recorded[kGroup] = {};  // truth of each lane; null for mirrored lanes
    for (int l = 0; l < group.lanes; ++l) recorded[l] = rollout.recorded(rollout.segment(samples.group, l), i);
    for (int s = 0; s < samples.count; ++s) {
      const int lane = offsets[s] % kGroup, time = offsets[s] / kGroup;
      const float truth = recorded[lane] != nullptr ? recorded[lane][time]
                                                    : rollout.state(rollout.segment(samples.group, lane), i, time);
      const float estimate = n != nullptr ? mean + scale * n[s] : z[offsets[s]];
      const float error = estimate - truth;
      squares += weights[s] * error * error;
      errors[s] = error;
    }
    squares_[i] = static_cast<double>(per_unit(i)) * static_cast<double>(squares);
    if (has_network()) std::fill_n(network_->output_cotangent() + i * kRow, kBlock, 0.0F);
  }
}

void EstimateBlock::backward(const float* parameters, const float* transposed) {
  if (!has_network()) return;
  network_->backward(parameters, transposed);
  pull_back_features();
}

}  // namespace nlo::trainer
