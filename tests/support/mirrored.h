// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "trainer/data/dataset.h"
#include "trainer/data/mirror.h"

namespace nlo::trainer::testing {

/// Returns a dataset that also has the mirror image of each run: all channels except those in `even` change their sign.
inline Dataset mirrored(Dataset dataset, const std::vector<std::string>& even = {}) {
  std::vector<std::string> odd;
  for (const auto& channels : {dataset.readings(), dataset.states})
    for (const std::string& name : channel_names(channels))
      if (std::ranges::find(even, name) == even.end()) odd.push_back(name);
  dataset.mirror = mirror_of(odd, dataset.readings(), dataset.states);
  return dataset;
}

}  // namespace nlo::trainer::testing
