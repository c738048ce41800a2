// SPDX-License-Identifier: MIT
#include "trainer/learn/training/blocks.h"

#include <algorithm>
#include <cmath>

#include "trainer/learn/losses/loss_registry.h"

namespace nlo::trainer {

namespace {

/// The last sample of each segment, unless it is masked.
std::vector<SampleSet> segment_ends(const Rollout& rollout) {
  std::vector<SampleSet> ends(rollout.groups().size());
  for (std::size_t g = 0; g < ends.size(); ++g) {
    for (int lane = 0; lane < rollout.groups()[g].lanes; ++lane) {
      const Segment& segment = rollout.segment(static_cast<int>(g), lane);
      const int last = segment.length - 1;
      const float weight = rollout.data()
                               .runs[static_cast<std::size_t>(segment.run)]
                               .weight[static_cast<std::size_t>(segment.start + last)];
      if (weight <= 0.0F) continue;
      ends[g].offsets.push_back(last * kGroup + lane);
      ends[g].weights.push_back(weight);
    }
  }
  return ends;
}

}  // namespace

void Blocks::draw(const Experiment& experiment, const Rollout& rollout, long step, bool all, const LossConfig& loss,
                  ThreadPool& pool) {
  blocks_.clear();
  // With `all`, every step has the same samples: all samples of all runs.
  std::vector<SampleSet>& samples = all ? all_samples_ : samples_;
  if (!all || samples.empty()) samples = draw_samples(experiment, rollout, step, all, pool);
  settled_weight_ = 0.0;
  if (all && settled_from_ > 0.0)
    add_split(samples);
  else
    add(BlockKind::kRunning, samples);
  shares_.assign(samples.size(), 1.0);
  group_weights_.clear();
  for (const SampleSet& set : samples) group_weights_.push_back(set.total_weight);
  total_weight_ = 0.0;
  for (const SampleSet& set : samples) total_weight_ += set.total_weight;
  if (blocks_.empty()) total_weight_ = 1.0;  // all drawn samples are masked: nothing to learn, and no division by 0
  horizon_s_ = 1.0;
  const auto segments = static_cast<double>(rollout.segments().size());
  if (loss.reduction == Reduction::kIntegral) {
    double steps = 0.0;
    for (const Segment& segment : rollout.segments()) steps += segment.length - 1;
    horizon_s_ = rollout.data().sample_period_s * steps / segments;
  }
  running_share_ = horizon_s_ / total_weight_;
  const int points = has_loss<EquationLoss>(loss) ? rollout.data().collocation.count : 0;
  for (int first = 0; first < points; first += kBlock)
    blocks_.push_back({BlockKind::kCollocation, {nullptr, 0, first, std::min(kBlock, points - first)}});
  first_terminal_ = blocks_.size();
  if (const auto at_ends = [](const EstimateLoss& form) { return form.at == EstimateLoss::At::kSegmentEnds; };
      any_loss<EstimateLoss>(loss, at_ends)) {
    terminal_share_ = 1.0 / segments;
    ends_ = segment_ends(rollout);
    add(BlockKind::kTerminal, ends_);
  }
}

double Blocks::share_by_logarithm(const std::vector<double>& squares, double floor) {
  const auto groups = static_cast<double>(squares.size());
  double lacking = 0.0;
  for (std::size_t g = 0; g < squares.size(); ++g) {
    if (group_weights_[g] <= 0.0) continue;
    const double mean = squares[g] / group_weights_[g], level = mean + floor;
    shares_[g] = total_weight_ / (groups * group_weights_[g] * level);
    lacking += (std::log(level) - mean / level) / groups;
  }
  return lacking;
}

void Blocks::add(BlockKind kind, const std::vector<SampleSet>& sets) {
  for (std::size_t g = 0; g < sets.size(); ++g)
    add(kind, sets[g], static_cast<int>(g), 0, static_cast<int>(sets[g].offsets.size()), false);
}

void Blocks::add(BlockKind kind, const SampleSet& set, int group, int begin, int end, bool settled) {
  for (int first = begin; first < end; first += kBlock)
    blocks_.push_back({kind, {&set, group, first, std::min(kBlock, end - first)}, settled});
}

void Blocks::add_split(const std::vector<SampleSet>& sets) {
  for (std::size_t g = 0; g < sets.size(); ++g) {
    const SampleSet& set = sets[g];
    // With all samples, the offsets are in the order of time.
    const auto first = std::ranges::lower_bound(set.offsets, std::ceil(settled_from_) * kGroup);
    const auto split = static_cast<int>(first - set.offsets.begin()), end = static_cast<int>(set.offsets.size());
    add(BlockKind::kRunning, set, static_cast<int>(g), 0, split, false);
    add(BlockKind::kRunning, set, static_cast<int>(g), split, end, true);
    for (int i = split; i < end; ++i) settled_weight_ += static_cast<double>(set.weights[static_cast<std::size_t>(i)]);
  }
}

}  // namespace nlo::trainer
