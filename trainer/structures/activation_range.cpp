// SPDX-License-Identifier: MIT
#include "trainer/structures/activation_range.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "codegen/model/activations.h"
#include "codegen/reference/reference_network.h"
#include "trainer/structures/for_each_sample.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

}  // namespace

void record_largest_activations(codegen::Model& model, const Rollout& rollout) {
  codegen::Network* map = codegen::inverse_map(model);
  if (map == nullptr || map->layers.size() < 2) return;
  if (std::isfinite(codegen::activation_row(map->activation).largest_value)) return;

  constexpr long kMost = 1 << 18;
  constexpr Index kBlock = 512;
  long samples = 0;
  for_each_sample(rollout, [&](const Segment&, const SegmentGroup&, int, int) { ++samples; });
  const long stride = (samples + kMost - 1) / kMost;

  const codegen::ReferenceNetwork<double> reference(*map);
  std::vector<double> largest(map->layers.size() - 1, 0.0);
  MatrixXd block(map->inputs(), kBlock);  // [z; y], or z
  Index filled = 0;
  const auto add = [&] {
    const std::vector<double> values = reference.largest_activations(block.leftCols(filled));
    for (std::size_t l = 0; l < largest.size(); ++l) largest[l] = std::max(largest[l], values[l]);
    filled = 0;
  };
  long visited = 0;
  for_each_sample(rollout, [&](const Segment&, const SegmentGroup& group, int lane, int time) {
    if (visited++ % stride != 0) return;
    for (Index i = 0; i < block.rows(); ++i) {
      const bool is_latent = i < model.nz();
      const std::vector<float>& signal = is_latent ? group.latent : group.readings;
      const Index row = is_latent ? i : i - model.nz();
      block(i, filled) =
          static_cast<double>(signal[group.at(static_cast<int>(row), time) + static_cast<std::size_t>(lane)]);
    }
    if (++filled == kBlock) add();
  });
  if (filled > 0) add();
  map->largest_activations = largest;
}

}  // namespace nlo::trainer
