// SPDX-License-Identifier: MIT
// The samples at which one evaluation of the cost is computed, in blocks for a network, and the factor of each kind of
// sample in the cost: samples of the running cost, collocation points, ends of segments.
#pragma once

#include <vector>

#include "trainer/base/parallel.h"
#include "trainer/config/experiment.h"
#include "trainer/learn/losses/estimate_block.h"
#include "trainer/rollout/rollout.h"
#include "trainer/rollout/sampling.h"

namespace nlo::trainer {

enum class BlockKind { kRunning, kTerminal, kCollocation };

/// Samples that are computed together. For collocation points, which have no set, only `first` and `count` are valid.
struct Block {
  BlockKind kind;
  SampleRange samples;
  bool settled = false;  ///< true if the samples are after the transient, see Blocks::split_at()
};

class Blocks {
 public:
  /// From now on, draw() of all samples puts those before and those after the end of the transient into different
  /// blocks.
  ///   settled_from  end of the transient [sample periods since the start of the segment]
  void split_at(double settled_from) { settled_from_ = settled_from; }

  /// Draws the samples of a step from the roll-out, or takes all of them, and assigns them to these losses.
  void draw(const Experiment& experiment, const Rollout& rollout, long step, bool all, const LossConfig& loss,
            ThreadPool& pool);

  const std::vector<Block>& all() const { return blocks_; }
  /// Returns the index of the first terminal block. Terminal blocks are the last ones.
  std::size_t first_terminal() const { return first_terminal_; }

  /// Changes the running cost to the mean of log(m + floor) over the groups, where m is the mean squared error of a
  /// group. Then a run with little noise counts as much as a run with much noise. The gradient at a sample is that of
  /// the mean squared error times 1 / (m + floor), and the shares are set to this factor. Returns the difference
  /// between the cost and the sum of squares with these shares.
  ///   squares  sum of weighted squared errors of each group
  double share_by_logarithm(const std::vector<double>& squares, double floor);

  double total_weight() const { return total_weight_; }      ///< total weight of the running samples
  double settled_weight() const { return settled_weight_; }  ///< weight after the transient; 0 without split
  double horizon_s() const { return horizon_s_; }  ///< mean length of the segments if the cost is an integral, else 1
  double running_share() const { return running_share_; }  ///< factor of a sample with weight 1 in the running cost
  /// Returns the running share in a group, if groups count by the logarithm of their errors.
  double running_share(int group) const { return running_share_ * shares_[static_cast<std::size_t>(group)]; }
  double terminal_share() const { return terminal_share_; }  ///< factor of the end of a segment in the terminal cost

 private:
  void add(BlockKind kind, const std::vector<SampleSet>& sets);
  void add(BlockKind kind, const SampleSet& set, int group, int begin, int end, bool settled);
  void add_split(const std::vector<SampleSet>& sets);

  std::vector<SampleSet> samples_, all_samples_, ends_;  // one per group
  std::vector<Block> blocks_;
  std::vector<double> shares_, group_weights_;  // one for each group
  std::size_t first_terminal_ = 0;
  double settled_from_ = 0.0;  // 0: draw() does not split
  double total_weight_ = 0.0, settled_weight_ = 0.0, horizon_s_ = 1.0, running_share_ = 0.0, terminal_share_ = 0.0;
};

}  // namespace nlo::trainer
