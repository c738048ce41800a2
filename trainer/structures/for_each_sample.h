// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "trainer/rollout.h"

namespace nlo::trainer {

/// Calls visit(segment, group, lane, time) for every recorded sample of a rollout.
template <class Visit>
void for_each_sample(Rollout& rollout, const Visit& visit) {
  for (std::size_t g = 0; g < rollout.groups().size(); ++g) {
    const SegmentGroup& group = rollout.groups()[g];
    for (int l = 0; l < group.lanes; ++l) {
      const Segment& segment = rollout.segment(static_cast<int>(g), l);
      for (int t = 0; t < segment.length; ++t) visit(segment, group, l, t);
    }
  }
}

/// How much the truth counts there; 0: masked.
inline float weight(const Rollout& rollout, const Segment& segment, int time) {
  return rollout.data()
      .runs[static_cast<std::size_t>(segment.run)]
      .weight[static_cast<std::size_t>(segment.start + time)];
}

}  // namespace nlo::trainer
