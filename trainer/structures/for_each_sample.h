// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>

#include "trainer/rollout/rollout.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// Calls visit(segment, group, lane, time) for every sample of a rollout that has an estimate, from the first of each
/// segment on, also if its truth is masked.
template <class Visit>
void for_each_sample(const Rollout& rollout, const Visit& visit) {
  for (std::size_t g = 0; g < rollout.groups().size(); ++g) {
    const SegmentGroup& group = rollout.groups()[g];
    for (int l = 0; l < group.lanes; ++l) {
      const Segment& segment = rollout.segment(static_cast<int>(g), l);
      const int first_estimate = rollout.data().runs[static_cast<std::size_t>(segment.run)].first_estimate;
      for (int t = std::max(0, first_estimate - segment.start); t < segment.length; ++t) visit(segment, group, l, t);
    }
  }
}

/// Returns a feature of T* at a sample, without its mean, scale and clock.
inline float feature_value(const Feature& feature, const SegmentGroup& group, int lane, int time) {
  const auto l = static_cast<std::size_t>(lane);
  const float* z = feature.latent >= 0 ? group.latent.data() + group.at(feature.latent, time) + l : nullptr;
  const float* y = feature.reading >= 0 ? group.readings.data() + group.at(feature.reading, time) + l : nullptr;
  return FeatureFormula<float>(feature).raw(z, y);
}

/// Returns the normalised feature that T* reads.
inline float normalised_feature(const Feature& feature, const SegmentGroup& group, int lane, int time) {
  const float u = (feature_value(feature, group, lane, time) - feature.mean) / feature.scale;
  if (feature.clock < 0) return u;
  return u * group.latent[group.at(feature.clock, time) + static_cast<std::size_t>(lane)];
}

/// Returns the weight of the truth at a sample; 0: masked.
inline float weight(const Rollout& rollout, const Segment& segment, int time) {
  return rollout.data()
      .runs[static_cast<std::size_t>(segment.run)]
      .weight[static_cast<std::size_t>(segment.start + time)];
}

}  // namespace nlo::trainer
