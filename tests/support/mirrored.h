// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "trainer/data/dataset.h"
#include "trainer/symmetry/symmetry.h"

namespace nlo::trainer::testing {

/// A dataset whose mirror images are runs too: all channels turn their sign but those named.
inline Dataset mirrored(Dataset dataset, const std::vector<std::string>& even = {}) {
  SymmetryConfig mirror{.kind = "sign"};
  for (const auto& channels : {dataset.readings(), dataset.states})
    for (const std::string& name : channel_names(channels))
      if (std::ranges::find(even, name) == even.end()) mirror.channels.push_back(name);
  dataset.symmetries.push_back(on_channels(mirror, dataset.readings(), dataset.states));
  return dataset;
}

}  // namespace nlo::trainer::testing
