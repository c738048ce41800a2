// SPDX-License-Identifier: MIT
#include "trainer/data/log_blocks.h"

#include <algorithm>
#include <utility>

namespace nlo::trainer {
namespace {

using Eigen::Index;

Dataset with_mask(Dataset logs, int block, int blocks, bool masks_the_block) {
  for (Trajectory& run : logs.trajectories)
    for (Index k = 0; k < run.samples(); ++k)
      if ((block_of(k, run.samples(), blocks) == block) == masks_the_block) run.weight(k) = 0.0;
  return logs;
}

bool has_truth(const Dataset& logs) {
  return std::ranges::any_of(logs.trajectories, [](const Trajectory& run) { return (run.weight.array() > 0.0).any(); });
}

}  // namespace

int block_of(Index sample, Index samples, int blocks) {
  return static_cast<int>(sample * blocks / samples);
}

Dataset only_block(Dataset logs, int block, int blocks) {
  return with_mask(std::move(logs), block, blocks, false);
}

Dataset without_block(Dataset logs, int block, int blocks) {
  return with_mask(std::move(logs), block, blocks, true);
}

std::optional<LeftOutBlock> leave_out_block(const Dataset& logs, int block, int blocks) {
  LeftOutBlock parts{without_block(logs, block, blocks), only_block(logs, block, blocks)};
  if (!has_truth(parts.kept) || !has_truth(parts.left_out)) return std::nullopt;
  return parts;
}

}  // namespace nlo::trainer
