// SPDX-License-Identifier: MIT
#include "trainer/training/objective.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "trainer/structures/make_dynamics.h"

namespace nlo::trainer {

namespace {

/// Blocks are shared out over a number of chunks that does not depend on the number of threads; each chunk has a
/// gradient of its own, and these are added in order: the same bytes from any number of threads.
constexpr int kChunks = 16;

}  // namespace

Objective::Objective(const Experiment& experiment, const ObserverStructure& structure, const TrainingData& data,
                     ThreadPool& pool)
    : experiment_(&experiment),
      structure_(&structure),
      data_(&data),
      pool_(&pool),
      rollout_(data),
      chunks_(2 * kChunks),
      transposed_(static_cast<std::size_t>(structure.network.parameters)) {}

void Objective::prepare(const float* parameters) {
  if (dynamics_ == nullptr) {
    dynamics_ = make_dynamics(*experiment_, *structure_, data_->steps_s, pool_->threads());
    for (int t = 0; t < pool_->threads(); ++t) workspaces_.emplace_back(*structure_, experiment_->loss);
  }
  dynamics_->prepare(parameters);
}

void Objective::roll_out(const float* parameters, const std::vector<Segment>& segments, Purpose purpose, long step) {
  prepare(parameters);
  rollout_.run(segments, *dynamics_, experiment_->training.noise, experiment_->seed, purpose,
               static_cast<std::uint64_t>(step), *pool_);
}

const Rollout& Objective::roll_out_flight(const float* parameters) {
  roll_out(parameters, flight_segments(*experiment_, *data_), Purpose::kValidationNoise, 0);
  return rollout_;
}

ObjectiveValue Objective::evaluate(const float* parameters, long step, float* gradient) {
  roll_out(parameters, draw_segments(*experiment_, *data_, step), Purpose::kNoise, step);
  draw(step, experiment_->training.mode == TrainingMode::kFullBatch, experiment_->loss);
  return accumulate(parameters, gradient);
}

double Objective::validate(const float* parameters) {
  roll_out(parameters, whole_runs(*data_), Purpose::kValidationNoise, 0);
  static const LossConfig kPhysical;
  static const LossConfig kNormalised = [] {
    LossConfig loss;
    loss.scale = "normalised";
    return loss;
  }();
  const bool normalised = experiment_->loss.scale == "normalised";
  draw(0, true, normalised ? kNormalised : kPhysical);
  return accumulate(parameters, nullptr).rmse;
}

/// Draws the samples of a step and shares them out over blocks.
void Objective::draw(long step, bool all, const LossConfig& loss) {
  loss_ = &loss;
  blocks_.clear();
  // All samples of all runs are the same in every step.
  std::vector<SampleSet>& samples = all ? all_samples_ : samples_;
  if (!all || samples.empty()) samples = draw_samples(*experiment_, rollout_, step, all, *pool_);
  add_blocks(BlockKind::kRunning, samples);
  total_weight_ = 0.0;
  for (const SampleSet& set : samples) total_weight_ += set.total_weight;
  if (blocks_.empty()) total_weight_ = 1.0;  // all drawn samples are masked: nothing to learn, nothing to divide by
  horizon_s_ = 1.0;
  const auto segments = static_cast<double>(rollout_.segments().size());
  if (loss.reduction == "integral") {
    double steps = 0.0;
    for (const Segment& segment : rollout_.segments()) steps += segment.length - 1;
    horizon_s_ = data_->sample_period_s * steps / segments;
  }
  running_share_ = horizon_s_ / total_weight_;
  for (int first = 0; loss.pde_residual > 0.0 && first < data_->collocation.count; first += kBlock)
    blocks_.push_back({BlockKind::kCollocation, nullptr, 0, first, std::min(kBlock, data_->collocation.count - first)});
  first_terminal_ = blocks_.size();
  if (loss.terminal > 0.0) {
    terminal_share_ = 1.0 / segments;
    ends_ = segment_ends();
    add_blocks(BlockKind::kTerminal, ends_);
  }
}

void Objective::add_blocks(BlockKind kind, const std::vector<SampleSet>& sets) {
  for (std::size_t g = 0; g < sets.size(); ++g) {
    const int count = static_cast<int>(sets[g].offsets.size());
    for (int first = 0; first < count; first += kBlock)
      blocks_.push_back({kind, &sets[g], static_cast<int>(g), first, std::min(kBlock, count - first)});
  }
}

std::vector<SampleSet> Objective::segment_ends() const {
  std::vector<SampleSet> ends(rollout_.groups().size());
  for (std::size_t g = 0; g < ends.size(); ++g) {
    for (int lane = 0; lane < rollout_.groups()[g].lanes; ++lane) {
      const Segment& segment = rollout_.segment(static_cast<int>(g), lane);
      const int last = segment.length - 1;
      const float weight =
          data_->runs[static_cast<std::size_t>(segment.run)].weight[static_cast<std::size_t>(segment.start + last)];
      if (weight <= 0.0F) continue;
      ends[g].offsets.push_back(last * kGroup + lane);
      ends[g].weights.push_back(weight);
    }
  }
  return ends;
}

Objective::Workspace::Workspace(const ObserverStructure& structure, const LossConfig& loss) {
  if (!structure.features.empty()) network.emplace(structure.network);
  if (!structure.forward_map || !loss.needs_forward_map()) return;
  maps.emplace(structure, loss);
  const auto rows = [](std::size_t count) { return std::vector<float>(count * kRow); };
  const std::size_t nx = structure.state_scale.size(), nz = structure.latent_scale.size();
  const auto ny = static_cast<std::size_t>(structure.outputs);
  x = f = rows(nx);
  z = cotangent_z = rows(nz);
  y = h = rows(ny);
  weight = rows(1);
}

void Objective::read_features(const Block& block, WideBlock& network) const {
  const SegmentGroup& group = rollout_.groups()[static_cast<std::size_t>(block.group)];
  const int* offsets = block.samples->offsets.data() + block.first;
  const auto& features = structure_->features;
  for (std::size_t f = 0; f < features.size(); ++f) {
    const Feature& feature = features[f];
    float* row = network.input() + f * kRow;
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
}

void Objective::pull_back_features(const Block& block, const WideBlock& network) {
  SegmentGroup& group = rollout_.groups()[static_cast<std::size_t>(block.group)];
  const int* offsets = block.samples->offsets.data() + block.first;
  const auto& features = structure_->features;
  for (std::size_t f = 0; f < features.size(); ++f) {
    if (features[f].latent < 0) continue;
    float* g = group.cotangent.data() + group.at(features[f].latent, 0);
    const float* du = network.input_cotangent() + f * kRow;
    const float inverse = 1.0F / features[f].scale;
    for (int s = 0; s < block.count; ++s) g[offsets[s]] += inverse * du[s];
  }
}

/// |x - x_hat|^2 at a block's samples, and its cotangent: of the network's output, or of z where z is the estimate.
void Objective::state_error(const Block& block, Workspace& workspace, ChunkResult& result, bool backward) {
  SegmentGroup& group = rollout_.groups()[static_cast<std::size_t>(block.group)];
  const int* offsets = block.samples->offsets.data() + block.first;
  const float* weights = block.samples->weights.data() + block.first;
  const bool running = block.kind == BlockKind::kRunning;
  const double share = running ? loss_->state_error * running_share_ : loss_->terminal * terminal_share_;
  const bool normalised = loss_->scale == "normalised";
  for (std::size_t i = 0; i < structure_->state_scale.size(); ++i) {
    const float scale = structure_->state_scale[i];
    const float per_unit = normalised ? 1.0F / (scale * scale) : 1.0F;
    const float pull = 2.0F * per_unit * static_cast<float>(share);
    const float* n = workspace.network ? workspace.network->output() + i * kRow : nullptr;
    const float* z = n == nullptr ? group.latent.data() + group.at(static_cast<int>(i), 0) : nullptr;
    float* network_cotangent = workspace.network ? workspace.network->output_cotangent() + i * kRow : nullptr;
    float* latent_cotangent =
        n == nullptr && backward ? group.cotangent.data() + group.at(static_cast<int>(i), 0) : nullptr;
    float squares = 0.0F;
    for (int s = 0; s < block.count; ++s) {
      const int time = offsets[s] / kGroup;
      const Segment& segment = rollout_.segment(block.group, offsets[s] % kGroup);
      const TrainingData::Run& run = data_->runs[static_cast<std::size_t>(segment.run)];
      const float truth =
          segment.sign *
          run.states[i * static_cast<std::size_t>(run.samples) + static_cast<std::size_t>(segment.start + time)];
      const float estimate = n != nullptr ? structure_->state_mean[i] + scale * n[s] : z[offsets[s]];
      const float error = estimate - truth;
      squares += weights[s] * error * error;
      if (n != nullptr) {
        network_cotangent[s] = pull * scale * weights[s] * error;
      } else if (backward) {
        latent_cotangent[offsets[s]] += pull * weights[s] * error;
      }
    }
    if (n != nullptr) std::fill(network_cotangent + block.count, network_cotangent + kBlock, 0.0F);
    const double scaled = static_cast<double>(per_unit) * static_cast<double>(squares);
    if (running) result.squares += scaled;
    result.loss += share * scaled;
  }
}

/// Map consistency, reconstruction and the residual at the samples themselves.
void Objective::map_losses(const Block& block, Workspace& workspace, ChunkResult& result, bool backward) {
  SegmentGroup& group = rollout_.groups()[static_cast<std::size_t>(block.group)];
  const int* offsets = block.samples->offsets.data() + block.first;
  const float* weights = block.samples->weights.data() + block.first;
  const auto share = static_cast<float>(running_share_);
  const std::size_t nx = structure_->state_scale.size(), nz = structure_->latent_scale.size();
  const std::size_t ny = workspace.y.size() / kRow;
  const bool residual = loss_->pde_residual > 0.0 && data_->collocation.count == 0;
  for (int s = 0; s < block.count; ++s) {
    const auto at = static_cast<std::size_t>(s);
    const int time = offsets[s] / kGroup, lane = offsets[s] % kGroup;
    const Segment& segment = rollout_.segment(block.group, lane);
    const TrainingData::Run& run = data_->runs[static_cast<std::size_t>(segment.run)];
    const auto samples = static_cast<std::size_t>(run.samples);
    const auto k = static_cast<std::size_t>(segment.start + time);
    workspace.weight[at] = share * weights[s];
    for (std::size_t i = 0; i < nx; ++i) {
      workspace.x[i * kRow + at] = segment.sign * run.states[i * samples + k];
      if (residual) workspace.f[i * kRow + at] = segment.sign * run.derivatives[i * samples + k];
    }
    for (std::size_t r = 0; r < nz; ++r)
      workspace.z[r * kRow + at] = group.latent[group.at(static_cast<int>(r), time) + static_cast<std::size_t>(lane)];
    for (std::size_t j = 0; j < ny; ++j) {
      workspace.y[j * kRow + at] = group.outputs[group.at(static_cast<int>(j), time) + static_cast<std::size_t>(lane)];
      workspace.h[j * kRow + at] = segment.sign * run.outputs[j * samples + k];
    }
  }
  const MapSamples<float> samples{.count = block.count,
                                  .x = workspace.x.data(),
                                  .z = workspace.z.data(),
                                  .y = workspace.y.data(),
                                  .f = workspace.f.data(),
                                  .h = workspace.h.data(),
                                  .weight = workspace.weight.data()};
  if (loss_->map_consistency > 0.0 || loss_->reconstruction > 0.0) {
    std::fill(workspace.cotangent_z.begin(), workspace.cotangent_z.end(), 0.0F);
    result.loss += workspace.maps->consistency(samples, backward ? workspace.cotangent_z.data() : nullptr);
    for (std::size_t r = 0; backward && r < nz; ++r) {
      float* g = group.cotangent.data() + group.at(static_cast<int>(r), 0);
      for (int s = 0; s < block.count; ++s)
        g[offsets[s]] += workspace.cotangent_z[r * kRow + static_cast<std::size_t>(s)];
    }
  }
  if (residual) result.loss += workspace.maps->residual(samples, backward);
}

void Objective::collocation_losses(const Block& block, Workspace& workspace, ChunkResult& result, bool backward) {
  const auto count = static_cast<std::size_t>(data_->collocation.count), first = static_cast<std::size_t>(block.first);
  const auto gather = [&](const std::vector<float>& from, std::vector<float>& to) {
    for (std::size_t row = 0; row < from.size() / count; ++row)
      std::copy_n(from.data() + row * count + first, block.count, to.data() + row * kRow);
  };
  gather(data_->collocation.x, workspace.x);
  gather(data_->collocation.f, workspace.f);
  gather(data_->collocation.h, workspace.h);
  std::fill_n(workspace.weight.data(), block.count,
              static_cast<float>(horizon_s_) / static_cast<float>(data_->collocation.count));
  const MapSamples<float> samples{.count = block.count,
                                  .x = workspace.x.data(),
                                  .f = workspace.f.data(),
                                  .h = workspace.h.data(),
                                  .weight = workspace.weight.data()};
  result.loss += workspace.maps->residual(samples, backward);
}

void Objective::run_block(const Block& block, const float* network, Workspace& workspace, ChunkResult& result,
                          bool backward) {
  if (block.kind == BlockKind::kCollocation) return collocation_losses(block, workspace, result, backward);
  if (workspace.network) {
    read_features(block, *workspace.network);
    workspace.network->forward(network);
  }
  state_error(block, workspace, result, backward);
  if (backward && workspace.network) {
    workspace.network->backward(network, transposed_.data());
    pull_back_features(block, *workspace.network);
  }
  if (workspace.maps && loss_->needs_forward_map() && block.kind == BlockKind::kRunning)
    map_losses(block, workspace, result, backward);
}

ObjectiveValue Objective::accumulate(const float* parameters, float* gradient) {
  const bool backward = gradient != nullptr;
  const float* network = parameters + structure_->dynamics_parameters();
  const float* forward_map = network + structure_->network.parameters;
  const std::vector<double> eigenvalues = structure_->eigenvalues_at(parameters);
  const bool maps = structure_->forward_map && loss_->needs_forward_map();
  for (Workspace& workspace : workspaces_) {
    if (maps) workspace.maps->prepare(network, forward_map, eigenvalues);
  }
  if (backward) {
    transpose_weights(structure_->network, network, transposed_.data());
    for (SegmentGroup& group : rollout_.groups()) group.cotangent.assign(group.latent.size(), 0.0F);
  }
  const auto inverse_size = static_cast<std::size_t>(structure_->network.parameters);
  const auto run_chunk = [&](std::size_t begin, std::size_t end, ChunkResult& result, Workspace& workspace) {
    result.loss = result.squares = 0.0;
    if (backward && workspace.network) workspace.network->clear_gradient();
    if (backward && maps) workspace.maps->clear_gradient();
    for (std::size_t b = begin; b < end; ++b) run_block(blocks_[b], network, workspace, result, backward);
    if (!backward) return;
    result.gradient.assign(static_cast<std::size_t>(structure_->parameters() - structure_->dynamics_parameters()),
                           0.0F);
    result.eigenvalues.assign(eigenvalues.size(), 0.0);
    if (workspace.network) workspace.network->gradient(result.gradient.data());
    if (!maps) return;
    std::vector<float> inverse_part(inverse_size);
    workspace.maps->gradient(inverse_part.data(), result.gradient.data() + inverse_size, result.eigenvalues.data());
    for (std::size_t i = 0; i < inverse_size; ++i) result.gradient[i] += inverse_part[i];
  };
  // The end of a segment may be a running sample too: two threads must not add to its cotangent at a time.
  used_chunks_ = 0;
  for (const auto& [first, last] : {std::pair{std::size_t{0}, first_terminal_}, {first_terminal_, blocks_.size()}}) {
    if (first == last) continue;
    pool_->run(kChunks, [&, first = first, blocks = last - first](int chunk, int thread) {
      const auto c = static_cast<std::size_t>(chunk);
      run_chunk(first + blocks * c / kChunks, first + blocks * (c + 1) / kChunks, chunks_[used_chunks_ + c],
                workspaces_[static_cast<std::size_t>(thread)]);
    });
    used_chunks_ += kChunks;
  }
  ObjectiveValue value;
  for (const ChunkResult& chunk : results()) {
    value.loss += chunk.loss;
    value.rmse += chunk.squares / total_weight_;
  }
  value.rmse = std::sqrt(value.rmse);
  for (int r = 0; r < structure_->latent.learned; ++r) {
    const double lambda = eigenvalues[static_cast<std::size_t>(r)];
    value.loss += loss_->eigenvalue_penalty * horizon_s_ * lambda * lambda;
  }
  if (backward) add_gradients(parameters, gradient);
  return value;
}

/// Adds up the chunks' gradients of the networks, and the latent system's by its own backward pass.
void Objective::add_gradients(const float* parameters, float* gradient) {
  std::fill(gradient, gradient + structure_->parameters(), 0.0F);
  const int dynamics_size = structure_->dynamics_parameters();
  for (const ChunkResult& chunk : results()) {
    for (std::size_t i = 0; i < chunk.gradient.size(); ++i)
      gradient[static_cast<std::size_t>(dynamics_size) + i] += chunk.gradient[i];
  }
  if (!latent_system_learns(*experiment_, *structure_)) return;
  auto& groups = rollout_.groups();
  pool_->run(static_cast<int>(groups.size()),
             [&](int g, int thread) { dynamics_->backward(groups[static_cast<std::size_t>(g)], thread); });
  const std::vector<double> eigenvalues = structure_->eigenvalues_at(parameters);
  for (int p = 0; p < dynamics_size; ++p) {
    const auto at = static_cast<std::size_t>(p);
    double total = 0.0;
    if (p < structure_->latent.learned) {  // both -exp(p) and exp(p) have the slope lambda
      const double lambda = eigenvalues[at];
      total += 2.0 * loss_->eigenvalue_penalty * horizon_s_ * lambda * lambda;
      for (const ChunkResult& chunk : results()) total += chunk.eigenvalues[at] * lambda;
    }
    for (const SegmentGroup& group : groups) total += group.gradient[at];
    gradient[at] = static_cast<float>(total);
  }
}

}  // namespace nlo::trainer
