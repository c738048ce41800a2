// SPDX-License-Identifier: MIT
#include "codegen/fold/fold.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "codegen/structures/structure_module.h"

namespace nlo::codegen {

int stale_after(const Model& m) {
  constexpr double kFewest = 5.0, kMost = 16383.0;  // range of the runtime's counter
  constexpr int kUnknown = 10;
  const std::optional<double> fastest = module_of(m).fastest_mode(m);
  if (!fastest) return kUnknown;
  return static_cast<int>(std::clamp(std::round(1.0 / (*fastest * m.sample_period_s)), kFewest, kMost));
}

FoldedModel fold(const Model& m) {
  FoldedModel folded;
  for (const Named<const Network>& n : networks(m)) {
    folded.networks.push_back(fold(*n.network, n.reads));
    folded.networks.back().field = n.field;
  }
  if (linear_latent(m) != nullptr) folded.step = latent_step(m, m.sample_period_s);
  folded.steady_gain = steady_gain(m);
  folded.stale_after = stale_after(m);
  folded.ranges = flown_ranges(m);
  if (m.error) folded.error = fold(*m.error);
  return folded;
}

}  // namespace nlo::codegen
