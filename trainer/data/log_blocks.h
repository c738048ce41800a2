// SPDX-License-Identifier: MIT
// Blocks of a log: contiguous parts of each run, of equal length. If there is a single log, they are left out in turn,
// as whole logs are if there are several.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "trainer/data/dataset.h"

namespace nlo::trainer {

/// Returns the block, from 0 to `blocks` - 1, of a sample of a run. `samples` and `blocks` are at least 1.
int block_of(Eigen::Index sample, Eigen::Index samples, int blocks);

/// Returns the logs with the truth masked (weight 0) outside of block `block` of each run. The observer still reads the
/// whole run, so a block has no transient of its own; the first one has that of the run.
Dataset only_block(Dataset logs, int block, int blocks);

/// Returns the logs with the truth masked in block `block` of each run.
Dataset without_block(Dataset logs, int block, int blocks);

/// The same logs twice: without the truth of a block, and with that truth alone.
struct LeftOutBlock {
  Dataset kept, left_out;
};

/// Leaves out block `block` of each run. Returns nothing if either part has no truth that counts.
std::optional<LeftOutBlock> leave_out_block(const Dataset& logs, int block, int blocks);

}  // namespace nlo::trainer
