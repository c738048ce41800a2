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
  static const LossConfig kStateError;
  draw(0, true, kStateError);
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
  if (loss.reduction == Reduction::kIntegral) {
    double steps = 0.0;
    for (const Segment& segment : rollout_.segments()) steps += segment.length - 1;
    horizon_s_ = data_->sample_period_s * steps / segments;
  }
  running_share_ = horizon_s_ / total_weight_;
  const int points = has_loss<EquationLoss>(loss) ? data_->collocation.count : 0;
  for (int first = 0; first < points; first += kBlock)
    blocks_.push_back({BlockKind::kCollocation, {nullptr, 0, first, std::min(kBlock, points - first)}});
  first_terminal_ = blocks_.size();
  if (const auto at_ends = [](const EstimateLoss& form) { return form.at == EstimateLoss::At::kSegmentEnds; };
      any_loss<EstimateLoss>(loss, at_ends)) {
    terminal_share_ = 1.0 / segments;
    ends_ = segment_ends();
    add_blocks(BlockKind::kTerminal, ends_);
  }
}

void Objective::add_blocks(BlockKind kind, const std::vector<SampleSet>& sets) {
  for (std::size_t g = 0; g < sets.size(); ++g) {
    const int count = static_cast<int>(sets[g].offsets.size());
    for (int first = 0; first < count; first += kBlock)
      blocks_.push_back({kind, {&sets[g], static_cast<int>(g), first, std::min(kBlock, count - first)}});
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

Objective::Workspace::Workspace(const ObserverStructure& structure, const LossConfig& loss)
    : estimate(structure, loss.is_normalised()) {
  if (!structure.forward_map || !needs_forward_map(loss)) return;
  maps.emplace(structure, loss.is_normalised(), has_loss<EquationLoss>(loss));
  rows.emplace(structure);
  cotangent_z.resize(structure.latent_scale.size() * kRow);
}

/// The losses of x_hat at a block's samples; the running ones also tell the error.
void Objective::estimate_losses(const Block& block, const float* network, Workspace& workspace, ChunkResult& result,
                                bool backward) {
  EstimateBlock& estimate = workspace.estimate;
  estimate.evaluate(rollout_, block.samples, network);
  const bool running = block.kind == BlockKind::kRunning;
  const auto at = running ? EstimateLoss::At::kSamples : EstimateLoss::At::kSegmentEnds;
  for (std::size_t i = 0; running && i < estimate.states(); ++i) result.squares += estimate.squares(i);
  for_each_loss<EstimateLoss>(*loss_, [&](const EstimateLoss& term, double weight) {
    if (term.at == at) term.add(estimate, weight * (running ? running_share_ : terminal_share_), backward, result.loss);
  });
  if (backward) estimate.backward(network, transposed_.data());
}

/// The losses of T at the samples, and those of the plant's equations unless they are asked for elsewhere.
void Objective::map_losses(const Block& block, Workspace& workspace, ChunkResult& result, bool backward) {
  const bool equations = has_loss<EquationLoss>(*loss_) && data_->collocation.count == 0;
  const MapSamples<float> samples =
      workspace.rows->gather(rollout_, block.samples, static_cast<float>(running_share_), equations);
  if (has_loss<MapLoss>(*loss_)) {
    std::fill(workspace.cotangent_z.begin(), workspace.cotangent_z.end(), 0.0F);
    workspace.maps->forward(samples);
    double loss = 0.0;
    for_each_loss<MapLoss>(*loss_, [&](const MapLoss& term, double weight) {
      loss += term.value(*workspace.maps, samples, weight, backward ? workspace.cotangent_z.data() : nullptr);
    });
    result.loss += loss;
    if (backward) {
      workspace.maps->backward(samples.count);
      SampleRows::scatter(workspace.cotangent_z, block.samples, rollout_);
    }
  }
  if (equations) equation_losses(samples, workspace, result, backward);
}

void Objective::equation_losses(const MapSamples<float>& samples, Workspace& workspace, ChunkResult& result,
                                bool backward) const {
  for_each_loss<EquationLoss>(*loss_, [&](const EquationLoss& term, double weight) {
    result.loss += term.value(*workspace.maps, samples, weight, backward);
  });
}

void Objective::run_block(const Block& block, const float* network, Workspace& workspace, ChunkResult& result,
                          bool backward) {
  if (block.kind == BlockKind::kCollocation) {
    const float weight = static_cast<float>(horizon_s_) / static_cast<float>(data_->collocation.count);
    return equation_losses(workspace.rows->gather(data_->collocation, block.samples.first, block.samples.count, weight),
                           workspace, result, backward);
  }
  estimate_losses(block, network, workspace, result, backward);
  if (workspace.maps && needs_forward_map(*loss_) && block.kind == BlockKind::kRunning)
    map_losses(block, workspace, result, backward);
}

ObjectiveValue Objective::accumulate(const float* parameters, float* gradient) {
  const bool backward = gradient != nullptr;
  const float* network = parameters + structure_->dynamics_parameters();
  const float* forward_map = network + structure_->network.parameters;
  const std::vector<double> eigenvalues = structure_->eigenvalues_at(parameters);
  const bool maps = structure_->forward_map && needs_forward_map(*loss_);
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
    if (backward) workspace.estimate.clear_gradient();
    if (backward && maps) workspace.maps->clear_gradient();
    for (std::size_t b = begin; b < end; ++b) run_block(blocks_[b], network, workspace, result, backward);
    if (!backward) return;
    result.gradient.assign(static_cast<std::size_t>(structure_->parameters() - structure_->dynamics_parameters()),
                           0.0F);
    result.eigenvalues.assign(eigenvalues.size(), 0.0);
    workspace.estimate.gradient(result.gradient.data());
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
    for_each_loss<EigenvalueLoss>(
        *loss_, [&](const EigenvalueLoss& term, double weight) { term.add(weight * horizon_s_, lambda, value.loss); });
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
      double unused = 0.0;
      for_each_loss<EigenvalueLoss>(*loss_, [&](const EigenvalueLoss& term, double weight) {
        total += term.add(weight * horizon_s_, lambda, unused) * lambda;
      });
      for (const ChunkResult& chunk : results()) total += chunk.eigenvalues[at] * lambda;
    }
    for (const SegmentGroup& group : groups) total += group.gradient[at];
    gradient[at] = static_cast<float>(total);
  }
}

}  // namespace nlo::trainer
