// SPDX-License-Identifier: MIT
#include "trainer/objective.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace nlo::trainer {

namespace {

/// Blocks are shared out over a number of chunks that does not depend on the number of threads; each chunk has a
/// gradient of its own, and these are added in order: the same bytes from any number of threads.
constexpr int kChunks = 16;

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

}  // namespace

Objective::Objective(const Experiment& experiment, const KklStructure& structure, const TrainingData& data,
                     ThreadPool& pool)
    : experiment_(&experiment), structure_(&structure), data_(&data), pool_(&pool), rollout_(structure.latent, data) {
  for (int t = 0; t < pool.threads(); ++t) workspaces_.emplace_back(structure.network);
  chunks_.resize(kChunks);
  transposed_.resize(static_cast<std::size_t>(structure.network.parameters));
}

std::vector<Segment> Objective::draw_segments(long step) const {
  const TrainingConfig& training = experiment_->training;
  std::vector<Segment> segments;
  Indices random(stream_seed(experiment_->seed, Purpose::kSegments, static_cast<std::uint64_t>(step), 0));
  if (training.mode == "full_batch") {
    segments = whole_runs(*data_);
  } else {
    const int wanted = static_cast<int>(std::lround(training.segment_s / data_->sample_period_s)) + 1;
    int all_samples = 0;
    for (const auto& run : data_->runs) all_samples += run.samples;
    for (int i = 0; i < training.trajectories_per_step; ++i) {
      Segment segment;
      // Runs weigh by their length, so that every sample is as likely.
      int at = random.below(all_samples);
      while (at >= data_->runs[static_cast<std::size_t>(segment.run)].samples) {
        at -= data_->runs[static_cast<std::size_t>(segment.run++)].samples;
      }
      const int samples = data_->runs[static_cast<std::size_t>(segment.run)].samples;
      segment.length = training.segment_s > 0.0 ? std::min(wanted, samples) : samples;
      segment.start = random.below(samples - segment.length + 1);
      segments.push_back(segment);
    }
  }
  for (Segment& segment : segments) {
    if (training.mirror && random.unit() < 0.5F) segment.sign = -1.0F;
    if (training.noise_level_max > 0.0)
      segment.noise_level = static_cast<float>(training.noise_level_max) * random.unit();
  }
  return segments;
}

void Objective::draw_samples(long step, bool all) {
  const TrainingConfig& training = experiment_->training;
  samples_.resize(rollout_.groups().size());
  const auto segments = static_cast<int>(rollout_.segments().size());
  pool_->run(static_cast<int>(samples_.size()), [&](int g, int /*thread*/) {
    Samples& samples = samples_[static_cast<std::size_t>(g)];
    const SegmentGroup& group = rollout_.groups()[static_cast<std::size_t>(g)];
    std::vector<int> ticks(static_cast<std::size_t>(group.length), all ? 1 : 0);  // how often each is drawn
    if (!all) {
      Indices random(stream_seed(experiment_->seed, Purpose::kTicks, static_cast<std::uint64_t>(step),
                                 static_cast<std::uint64_t>(g)));
      const int count = std::max(1, training.samples_per_step / std::max(1, segments));
      const int early = static_cast<int>(std::lround(training.early_share * count));
      const int early_ticks = std::clamp(static_cast<int>(training.early_s / data_->sample_period_s), 1, group.length);
      for (int i = 0; i < count; ++i)
        ++ticks[static_cast<std::size_t>(random.below(i < early ? early_ticks : group.length))];
    }
    samples.offsets.clear();
    samples.weights.clear();
    // A tick means the same share of each lane's own length: runs are drawn by their lengths, so every sample is as
    // likely.
    std::array<int, kGroup> latest{};  // 1 + index of a lane's latest sample: ticks that meet there add up
    for (int t = 0; t < group.length; ++t) {
      if (ticks[static_cast<std::size_t>(t)] == 0) continue;
      for (int l = 0; l < group.lanes; ++l) {
        const Segment& segment = rollout_.segment(g, l);
        if (all && t >= segment.length) continue;
        const int at = all ? t : static_cast<int>(static_cast<long>(t) * segment.length / group.length);
        const auto& run = data_->runs[static_cast<std::size_t>(segment.run)];
        const float weight = run.weight[static_cast<std::size_t>(segment.start + at)] *
                             static_cast<float>(ticks[static_cast<std::size_t>(t)]);
        if (weight <= 0.0F) continue;
        int& last = latest[static_cast<std::size_t>(l)];
        if (last > 0 && samples.offsets[static_cast<std::size_t>(last - 1)] == at * kGroup + l) {
          samples.weights[static_cast<std::size_t>(last - 1)] += weight;
          continue;
        }
        samples.offsets.push_back(at * kGroup + l);
        samples.weights.push_back(weight);
        last = static_cast<int>(samples.offsets.size());
      }
    }
  });
  blocks_.clear();
  total_weight_ = 0.0;
  for (std::size_t g = 0; g < samples_.size(); ++g) {
    const int count = static_cast<int>(samples_[g].offsets.size());
    for (int first = 0; first < count; first += kBlock) {
      blocks_.push_back({static_cast<int>(g), first, std::min(kBlock, count - first)});
    }
    for (const float weight : samples_[g].weights) total_weight_ += static_cast<double>(weight);
  }
  if (blocks_.empty()) total_weight_ = 1.0;  // all drawn samples are masked: nothing to learn, nothing to divide by
}

void Objective::filter_segments(const float* parameters, const std::vector<Segment>& segments, Purpose purpose,
                                long step) {
  // Fixed eigenvalues need their coefficients once; on jittered logs there is one set per sample.
  if (!coefficients_current_ || experiment_->observer.learn_eigenvalues) {
    coefficients_.compute(structure_->latent, structure_->eigenvalues_at(parameters).data(), data_->steps_s);
    coefficients_current_ = true;
  }
  rollout_.run(segments, coefficients_, experiment_->training.noise, experiment_->seed, purpose,
               static_cast<std::uint64_t>(step), *pool_);
}

Rollout& Objective::filter_all(const float* parameters) {
  filter_segments(parameters, whole_runs(*data_), Purpose::kValidationNoise, 0);
  return rollout_;
}

ObjectiveValue Objective::evaluate(const float* parameters, long step, float* gradient) {
  filter_segments(parameters, draw_segments(step), Purpose::kNoise, step);
  draw_samples(step, experiment_->training.mode == "full_batch");
  return accumulate(parameters, gradient);
}

ObjectiveValue Objective::validate(const float* parameters) {
  filter_all(parameters);
  draw_samples(0, true);
  return accumulate(parameters, nullptr);
}

void Objective::run_block(const Block& block, const float* network, BlockWorkspace& workspace, ChunkResult& result,
                          bool backward) {
  SegmentGroup& group = rollout_.groups()[static_cast<std::size_t>(block.group)];
  const Samples& samples = samples_[static_cast<std::size_t>(block.group)];
  const int* offsets = samples.offsets.data() + block.first;
  const float* weights = samples.weights.data() + block.first;

  const auto& features = structure_->features;
  for (std::size_t f = 0; f < features.size(); ++f) {
    const Feature& feature = features[f];
    float* row = workspace.input() + f * kRow;
    const float inverse = 1.0F / feature.scale;
    const float* z = feature.latent >= 0 ? group.latent.data() + group.at(feature.latent, 0) : nullptr;
    const float* y = feature.output >= 0 ? group.outputs.data() + group.at(feature.output, 0) : nullptr;
    for (int s = 0; s < block.count; ++s) {
      float u = -feature.mean;
      if (z != nullptr) u += z[offsets[s]];
      if (y != nullptr) u += feature.output_gain * y[offsets[s]];
      row[s] = u * inverse;
    }
    std::fill(row + block.count, row + kBlock, 0.0F);
  }
  workspace.forward(network);

  const bool normalised = experiment_->training.loss_scale == "normalised";
  const double inverse_total = 1.0 / total_weight_;
  for (std::size_t i = 0; i < structure_->state_scale.size(); ++i) {
    const float scale = structure_->state_scale[i];
    const float per_unit = normalised ? 1.0F / (scale * scale) : 1.0F;
    const float* n = workspace.output() + i * kRow;
    float* cotangent = workspace.output_cotangent() + i * kRow;
    const float pull = 2.0F * per_unit * scale * static_cast<float>(inverse_total);
    float squares = 0.0F;
    for (int s = 0; s < block.count; ++s) {
      const int time = offsets[s] / kGroup;
      const Segment& segment = rollout_.segment(block.group, offsets[s] % kGroup);
      const TrainingData::Run& run = data_->runs[static_cast<std::size_t>(segment.run)];
      const float truth =
          segment.sign *
          run.states[i * static_cast<std::size_t>(run.samples) + static_cast<std::size_t>(segment.start + time)];
      const float error = structure_->state_mean[i] + scale * n[s] - truth;
      squares += weights[s] * error * error;
      cotangent[s] = pull * weights[s] * error;
    }
    std::fill(cotangent + block.count, cotangent + kBlock, 0.0F);
    result.squares += static_cast<double>(squares);
    result.loss += static_cast<double>(per_unit) * static_cast<double>(squares);
  }
  if (!backward) return;
  workspace.backward(network, transposed_.data());
  for (std::size_t f = 0; f < features.size(); ++f) {
    if (features[f].latent < 0) continue;
    float* g = group.cotangent.data() + group.at(features[f].latent, 0);
    const float* du = workspace.input_cotangent() + f * kRow;
    const float inverse = 1.0F / features[f].scale;
    for (int s = 0; s < block.count; ++s) g[offsets[s]] += inverse * du[s];
  }
}

ObjectiveValue Objective::accumulate(const float* parameters, float* gradient) {
  const bool backward = gradient != nullptr;
  const LatentShape& latent = structure_->latent;
  const float* network = parameters + latent.learned;
  auto& groups = rollout_.groups();
  if (backward) {
    transpose_weights(structure_->network, network, transposed_.data());
    for (SegmentGroup& group : groups) group.cotangent.assign(group.latent.size(), 0.0F);
  }
  const int blocks = static_cast<int>(blocks_.size());
  pool_->run(kChunks, [&](int chunk, int thread) {
    BlockWorkspace& workspace = workspaces_[static_cast<std::size_t>(thread)];
    ChunkResult& result = chunks_[static_cast<std::size_t>(chunk)];
    result.loss = result.squares = 0.0;
    const int begin = static_cast<int>(static_cast<long>(blocks) * chunk / kChunks);
    const int end = static_cast<int>(static_cast<long>(blocks) * (chunk + 1) / kChunks);
    if (backward) workspace.clear_gradient();
    for (int b = begin; b < end; ++b) {
      run_block(blocks_[static_cast<std::size_t>(b)], network, workspace, result, backward);
    }
    if (!backward) return;
    result.gradient.resize(static_cast<std::size_t>(structure_->network.parameters));
    workspace.gradient(result.gradient.data());
  });
  ObjectiveValue value;
  for (const ChunkResult& chunk : chunks_) {
    value.loss += chunk.loss / total_weight_;
    value.rmse += chunk.squares / total_weight_;
  }
  value.rmse = std::sqrt(value.rmse);
  const double penalty = experiment_->training.eigenvalue_penalty;
  const std::vector<double> eigenvalues = structure_->eigenvalues_at(parameters);
  for (int r = 0; r < latent.learned; ++r) {
    const double lambda = eigenvalues[static_cast<std::size_t>(r)];
    value.loss += penalty * lambda * lambda;
  }
  if (!backward) return value;

  std::fill(gradient, gradient + structure_->parameters(), 0.0F);
  for (const ChunkResult& chunk : chunks_) {
    for (std::size_t i = 0; i < chunk.gradient.size(); ++i)
      gradient[static_cast<std::size_t>(latent.learned) + i] += chunk.gradient[i];
  }
  if (experiment_->observer.learn_eigenvalues) {
    pool_->run(static_cast<int>(groups.size()), [&](int g, int /*thread*/) {
      adjoint_filter(latent, coefficients_, eigenvalues.data(), groups[static_cast<std::size_t>(g)]);
    });
    for (int r = 0; r < latent.learned; ++r) {
      const auto row = static_cast<std::size_t>(r);
      double total = 2.0 * penalty * eigenvalues[row] * eigenvalues[row];  // d(lambda^2)/dp = 2 lambda^2 for -+exp(p)
      for (const SegmentGroup& group : groups) total += group.gradient[row];
      gradient[row] = static_cast<float>(total);
    }
  }
  return value;
}

}  // namespace nlo::trainer
