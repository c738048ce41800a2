// SPDX-License-Identifier: MIT
#include "trainer/rollout/sampling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <span>

namespace nlo::trainer {

namespace {

/// Uniform integers below `bound`, drawn eight at a time.
class Indices {
 public:
  explicit Indices(std::uint64_t seed) : random_(seed) {}
  int below(int bound) { return std::min(bound - 1, static_cast<int>(unit() * static_cast<float>(bound))); }
  float unit() {
    if (next_ == RandomLanes::kLanes) {
      random_.uniform(draw_.data());
      next_ = 0;
    }
    return draw_[static_cast<std::size_t>(next_++)];
  }

 private:
  RandomLanes random_;
  RandomLanes::Floats draw_{};
  int next_ = RandomLanes::kLanes;
};

/// Makes each sensor with may_fail missing in a share `dropout` of the segments: in half of them for the whole segment,
/// in the other half for a part of it.
void add_outages(const Experiment& experiment, const TrainingData& data, long step, std::vector<Segment>& segments) {
  const std::size_t sensors = data.failures.outputs.size();
  if (sensors == 0 || experiment.training.dropout == 0.0) return;
  Indices random(stream_seed(experiment.seed, Purpose::kOutages, static_cast<std::uint64_t>(step), 0));
  for (Segment& segment : segments) {
    segment.outages.resize(sensors);
    for (Outage& outage : segment.outages) {
      if (random.unit() >= static_cast<float>(experiment.training.dropout)) continue;
      outage = {0, segment.length};
      if (random.unit() < 0.5F) continue;
      outage.from = random.below(segment.length);
      outage.to = outage.from + 1 + random.below(segment.length - outage.from);
    }
  }
}

/// Moves the segments of runs with process noise into groups of their own, if only a share of the runs has it. A loss
/// with reduction = "logarithm" has one logarithm for each group. In mixed groups the large errors of runs with
/// process noise would set the weight of the other runs. The position of these groups is drawn, so that every noise of
/// a mixture is equally frequent among them.
void gather_process_noise(const Experiment& experiment, const TrainingData& data, Indices& random,
                          std::vector<Segment>& segments) {
  if (experiment.simulation.process_noise_share == 1.0 || segments.empty()) return;
  const std::size_t first = data.simulated_share > 0.0 ? data.logged : 0;  // the first run that is simulated
  std::stable_partition(segments.begin(), segments.end(), [&](const Segment& segment) {
    const auto run = static_cast<std::size_t>(segment.run);
    return run >= first && experiment.simulation.has_process_noise(run - first);
  });
  const int groups = (static_cast<int>(segments.size()) + kGroup - 1) / kGroup;
  std::rotate(segments.begin(), segments.begin() + kGroup * random.below(groups), segments.end());
}

/// Returns the length of a segment. Segments may be short in the first steps, because a long roll-out teaches little
/// before the observer can follow a short one.
double segment_length_s(const TrainingConfig& training, long step) {
  if (training.first_segment_s == 0.0 || step < 0) return training.segment_s;
  const double part = std::min(1.0, 2.0 * static_cast<double>(step) / static_cast<double>(training.steps));
  return training.first_segment_s + part * (training.segment_s - training.first_segment_s);
}

}  // namespace

bool trains_whole_runs(const TrainingConfig& training) {
  return training.mode == TrainingMode::kFullBatch || training.segment_s == 0.0;
}

std::vector<Segment> draw_segments(const Experiment& experiment, const TrainingData& data, long step) {
  const TrainingConfig& training = experiment.training;
  std::vector<Segment> segments;
  Indices random(stream_seed(experiment.seed, Purpose::kSegments, static_cast<std::uint64_t>(step), 0));
  if (training.mode == TrainingMode::kFullBatch) {
    segments = whole_runs(data);
  } else {
    const int wanted = static_cast<int>(std::lround(segment_length_s(training, step) / data.sample_period_s)) + 1;
    const std::span<const TrainingData::Run> runs(data.runs);
    const auto samples_of = [](std::span<const TrainingData::Run> all) {
      return std::transform_reduce(all.begin(), all.end(), 0, std::plus<>{},
                                   [](const auto& run) { return run.samples; });
    };
    const int of_logs = samples_of(runs.first(data.logged)), of_others = samples_of(runs.subspan(data.logged));
    for (int i = 0; i < training.trajectories_per_step; ++i) {
      Segment segment;
      const bool both = of_logs > 0 && of_others > 0;
      const bool simulated = both ? random.unit() < static_cast<float>(data.simulated_share) : of_logs == 0;
      if (simulated) segment.run = static_cast<int>(data.logged);
      // Runs are drawn in proportion to their length, so that every sample is equally likely.
      int at = random.below(simulated ? of_others : of_logs);
      while (at >= data.runs[static_cast<std::size_t>(segment.run)].samples) {
        at -= data.runs[static_cast<std::size_t>(segment.run++)].samples;
      }
      const int samples = data.runs[static_cast<std::size_t>(segment.run)].samples;
      segment.length = training.segment_s > 0.0 ? std::min(wanted, samples) : samples;
      segment.start = random.below(samples - segment.length + 1);
      if (training.first_share > 0.0 && random.unit() < static_cast<float>(training.first_share)) segment.start = 0;
      segments.push_back(segment);
    }
    gather_process_noise(experiment, data, random, segments);
  }
  add_outages(experiment, data, step, segments);
  for (Segment& segment : segments) {
    if (!data.mirror.none()) segment.mirrored = random.unit() < 0.5F;
    if (training.noise_level_max > 0.0)
      segment.noise_level = static_cast<float>(training.noise_level_max) * random.unit();
  }
  return segments;
}

std::vector<Segment> flight_segments(const Experiment& experiment, const TrainingData& data) {
  std::vector<Segment> segments = whole_runs(data);
  for (Segment run : whole_runs(data)) {
    if (data.mirror.none()) break;
    run.mirrored = true;
    segments.push_back(run);
  }
  for (Segment& run : runs_with_failures(data, experiment.training.dropout)) segments.push_back(std::move(run));
  if (experiment.training.mode == TrainingMode::kFullBatch) return segments;
  constexpr long kNoStep = -1;  // a number that no training step has
  for (const Segment& segment : draw_segments(experiment, data, kNoStep)) segments.push_back(segment);
  return segments;
}

std::vector<SampleSet> draw_samples(const Experiment& experiment, const Rollout& rollout, long step, bool all,
                                    ThreadPool& pool) {
  const TrainingConfig& training = experiment.training;
  const TrainingData& data = rollout.data();
  std::vector<SampleSet> sets(rollout.groups().size());
  const auto segments = static_cast<int>(rollout.segments().size());
  pool.run(static_cast<int>(sets.size()), [&](int g, int /*thread*/) {
    SampleSet& samples = sets[static_cast<std::size_t>(g)];
    const SegmentGroup& group = rollout.groups()[static_cast<std::size_t>(g)];
    std::vector<int> ticks(static_cast<std::size_t>(group.length), all ? 1 : 0);  // how often each sample was drawn
    if (!all) {
      Indices random(stream_seed(experiment.seed, Purpose::kTicks, static_cast<std::uint64_t>(step),
                                 static_cast<std::uint64_t>(g)));
      const int drawn = std::max(1, training.samples_per_step / std::max(1, segments));
      const int early = static_cast<int>(std::lround(training.early_share * drawn));
      const int early_ticks = std::clamp(static_cast<int>(training.early_s / data.sample_period_s), 1, group.length);
      for (int i = 0; i < drawn; ++i)
        ++ticks[static_cast<std::size_t>(random.below(i < early ? early_ticks : group.length))];
    }
    // A tick is the same fraction of each lane's own length. Runs are drawn in proportion to their length, so every
    // sample is equally likely.
    std::array<int, kGroup> latest{};  // 1 + index of a lane's latest sample: ticks at the same sample add up
    std::array<const float*, kGroup> weights{};
    for (int l = 0; l < group.lanes; ++l) {
      const Segment& segment = rollout.segment(g, l);
      weights[static_cast<std::size_t>(l)] =
          data.runs[static_cast<std::size_t>(segment.run)].weight.data() + segment.start;
    }
    const auto most = static_cast<std::size_t>(std::min(group.length, std::accumulate(ticks.begin(), ticks.end(), 0))) *
                      static_cast<std::size_t>(group.lanes);
    samples.offsets.resize(most);
    samples.weights.resize(most);
    std::size_t count = 0;
    for (int t = 0; t < group.length; ++t) {
      if (ticks[static_cast<std::size_t>(t)] == 0) continue;
      for (int l = 0; l < group.lanes; ++l) {
        const int length = rollout.segment(g, l).length;
        if (all && t >= length) continue;
        // Most segments have the length of the group, and a division would be the most expensive operation here.
        const int at =
            all || length == group.length ? t : static_cast<int>(static_cast<long>(t) * length / group.length);
        const float weight =
            weights[static_cast<std::size_t>(l)][at] * static_cast<float>(ticks[static_cast<std::size_t>(t)]);
        if (weight <= 0.0F) continue;
        int& last = latest[static_cast<std::size_t>(l)];
        if (last > 0 && samples.offsets[static_cast<std::size_t>(last - 1)] == at * kGroup + l) {
          samples.weights[static_cast<std::size_t>(last - 1)] += weight;
          continue;
        }
        samples.offsets[count] = at * kGroup + l;
        samples.weights[count] = weight;
        last = static_cast<int>(++count);
      }
    }
    samples.offsets.resize(count);
    samples.weights.resize(count);
    for (const float weight : samples.weights) samples.total_weight += static_cast<double>(weight);
  });
  return sets;
}

}  // namespace nlo::trainer
