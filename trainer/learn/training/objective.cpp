// SPDX-License-Identifier: MIT
#include "trainer/learn/training/objective.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "trainer/structures/make_dynamics.h"

namespace nlo::trainer {
namespace {

/// Number of chunks of blocks. It does not depend on the number of threads. Each chunk has its own gradient, and these
/// are added in order, so the result has the same bytes for any number of threads.
constexpr int kChunks = 16;

/// Errors below this share of a state's deviation hardly lower the logarithmic cost.
constexpr double kLogarithmFloor = 0.005;

}  // namespace

bool is_behind(const ObjectiveValue& observer, const ObjectiveValue& filter, const std::vector<double>& deviations) {
  constexpr double kWorse = 1.02, kLeast = 1e-3;
  for (std::size_t i = 0; i < deviations.size(); ++i) {
    const auto ratio = [&](const std::vector<double>& own, const std::vector<double>& of_filter) {
      const double least = kLeast * deviations[i];
      return own.empty() ? 1.0 : std::max(own[i], least) / std::max(of_filter[i], least);
    };
    const double in_windows = std::sqrt(ratio(observer.transient_rmse, filter.transient_rmse) *
                                        ratio(observer.settled_rmse, filter.settled_rmse));
    if (std::max(ratio(observer.state_rmse, filter.state_rmse), in_windows) > kWorse) return true;
  }
  return false;
}

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
  rollout_.run(segments, *dynamics_, experiment_->training.all_noise(), experiment_->seed, purpose,
               static_cast<std::uint64_t>(step), *pool_, experiment_->training.input_noise);
}

ObjectiveValue Objective::evaluate(const float* parameters, long step, float* gradient) {
  roll_out(parameters, draw_segments(*experiment_, *data_, step), Purpose::kNoise, step);
  loss_ = &experiment_->loss;
  blocks_.draw(*experiment_, rollout_, step, experiment_->training.mode == TrainingMode::kFullBatch, *loss_, *pool_);
  return accumulate(parameters, gradient);
}

ObjectiveValue Objective::validation(const float* parameters) {
  roll_out_runs(parameters);
  static const LossConfig kStateError;
  loss_ = &kStateError;
  blocks_.draw(*experiment_, rollout_, 0, true, *loss_, *pool_);
  return accumulate(parameters, nullptr);
}

Objective::Workspace::Workspace(const ObserverStructure& structure, const LossConfig& loss)
    : estimate(structure, loss.is_normalised()) {
  if (!structure.forward_map || !needs_forward_map(loss)) return;
  maps.emplace(structure, loss.is_normalised(), has_loss<EquationLoss>(loss));
  rows.emplace(structure);
  cotangent_z.resize(structure.latent_scale.size() * kRow);
}

/// Evaluates the losses of x_hat at the samples of a block. The running losses also return the error.
void Objective::estimate_losses(const Block& block, const float* network, Workspace& workspace, ChunkResult& result,
                                bool backward) {
  EstimateBlock& estimate = workspace.estimate;
  estimate.evaluate(rollout_, block.samples, network);
  const bool running = block.kind == BlockKind::kRunning;
  const auto at = running ? EstimateLoss::At::kSamples : EstimateLoss::At::kSegmentEnds;
  std::vector<double>& squares = block.settled ? result.settled_squares : result.squares;
  for (std::size_t i = 0; running && i < estimate.states(); ++i) squares[i] += estimate.squares(i);
  for_each_loss<EstimateLoss>(*loss_, [&](const EstimateLoss& term, double weight) {
    if (term.at == at)
      term.add(estimate, weight * (running ? blocks_.running_share(block.samples.group) : blocks_.terminal_share()),
               backward, result.loss);
  });
  if (backward) estimate.backward(network, transposed_.data());
}

/// Evaluates the losses of T at the samples, and those of the plant's equations unless collocation points replace the
/// samples.
void Objective::map_losses(const Block& block, Workspace& workspace, ChunkResult& result, bool backward) {
  const bool equations = has_loss<EquationLoss>(*loss_) && data_->collocation.count == 0;
  const MapSamples<float> samples =
      workspace.rows->gather(rollout_, block.samples, static_cast<float>(blocks_.running_share()), equations);
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
    const float weight = static_cast<float>(blocks_.horizon_s()) / static_cast<float>(data_->collocation.count);
    return equation_losses(workspace.rows->gather(data_->collocation, block.samples.first, block.samples.count, weight),
                           workspace, result, backward);
  }
  estimate_losses(block, network, workspace, result, backward);
  if (workspace.maps && needs_forward_map(*loss_) && block.kind == BlockKind::kRunning)
    map_losses(block, workspace, result, backward);
}

void Objective::prepare_networks(const float* network, const std::vector<double>& eigenvalues, bool backward) {
  for (Workspace& workspace : workspaces_)
    if (trains_maps()) workspace.maps->prepare(network, network + structure_->network.parameters, eigenvalues);
  if (!backward) return;
  transpose_weights(structure_->network, network, transposed_.data());
  pool_->run(static_cast<int>(rollout_.groups().size()), [&](int g, int /*thread*/) {
    SegmentGroup& group = rollout_.groups()[static_cast<std::size_t>(g)];
    group.cotangent.assign(group.latent.size(), 0.0F);
  });
}

/// Evaluates blocks [begin, end): their part of the loss, and of the gradients of T*, T and the eigenvalues.
void Objective::run_chunk(std::size_t begin, std::size_t end, const float* network, Workspace& workspace,
                          ChunkResult& result, bool backward) {
  result.loss = 0.0;
  result.squares.assign(structure_->state_mean.size(), 0.0);
  result.settled_squares = result.squares;
  if (backward) workspace.estimate.clear_gradient();
  if (backward && trains_maps()) workspace.maps->clear_gradient();
  for (std::size_t b = begin; b < end; ++b) run_block(blocks_.all()[b], network, workspace, result, backward);
  if (!backward) return;
  const auto inverse_size = static_cast<std::size_t>(structure_->network.parameters);
  result.gradient.assign(static_cast<std::size_t>(structure_->parameters() - structure_->dynamics_parameters()), 0.0F);
  result.eigenvalues.assign(static_cast<std::size_t>(structure_->latent.rows), 0.0);
  workspace.estimate.gradient(result.gradient.data());
  if (!trains_maps()) return;
  std::vector<float> inverse_part(inverse_size);
  workspace.maps->gradient(inverse_part.data(), result.gradient.data() + inverse_size, result.eigenvalues.data());
  for (std::size_t i = 0; i < inverse_size; ++i) result.gradient[i] += inverse_part[i];
}

/// If the cost is a mean of logarithms, evaluates T* at all samples and weights each group by its error there. Returns
/// the difference between the cost and the weighted squares; 0 for other costs.
double Objective::share_by_logarithm(const float* network) {
  if (loss_->reduction != Reduction::kLogarithm) return 0.0;
  const std::vector<Block>& blocks = blocks_.all();
  std::vector<double> of_block(blocks.size(), 0.0), of_group(rollout_.groups().size(), 0.0);
  double floor = 0.0;
  pool_->run(static_cast<int>(blocks.size()), [&](int b, int thread) {
    const auto at = static_cast<std::size_t>(b);
    if (blocks[at].kind != BlockKind::kRunning) return;
    EstimateBlock& estimate = workspaces_[static_cast<std::size_t>(thread)].estimate;
    estimate.evaluate(rollout_, blocks[at].samples, network);
    for (std::size_t i = 0; i < estimate.states(); ++i) of_block[at] += estimate.squares(i);
  });
  const EstimateBlock& any = workspaces_.front().estimate;
  for (std::size_t i = 0; i < any.states(); ++i) {
    const double scale = static_cast<double>(structure_->state_scale[i]);
    floor += kLogarithmFloor * kLogarithmFloor * scale * scale * static_cast<double>(any.per_unit(i));
  }
  for (std::size_t b = 0; b < blocks.size(); ++b)
    if (blocks[b].kind == BlockKind::kRunning)
      of_group[static_cast<std::size_t>(blocks[b].samples.group)] += of_block[b];
  return loss_->weight("state_error") * blocks_.share_by_logarithm(of_group, floor);
}

std::vector<double> Objective::rmse_of(std::vector<double> ChunkResult::*squares, double weight) const {
  std::vector<double> rmse(structure_->state_mean.size(), 0.0);
  for (const ChunkResult& chunk : results())
    for (std::size_t i = 0; i < rmse.size(); ++i) rmse[i] += (chunk.*squares)[i] / weight;
  for (double& mean_square : rmse) mean_square = std::sqrt(mean_square);
  return rmse;
}

ObjectiveValue Objective::accumulate(const float* parameters, float* gradient) {
  const bool backward = gradient != nullptr;
  const float* network = parameters + structure_->dynamics_parameters();
  const std::vector<double> eigenvalues = structure_->eigenvalues_at(parameters);
  prepare_networks(network, eigenvalues, backward);
  const double by_logarithm = share_by_logarithm(network);
  // The end of a segment may also be a sample of the running cost. Two threads must not add to its cotangent at once.
  used_chunks_ = 0;
  const std::size_t ends = blocks_.first_terminal();
  for (const auto& [first, last] : {std::pair{std::size_t{0}, ends}, {ends, blocks_.all().size()}}) {
    if (first == last) continue;
    pool_->run(kChunks, [&, first = first, blocks = last - first](int chunk, int thread) {
      const auto c = static_cast<std::size_t>(chunk);
      run_chunk(first + blocks * c / kChunks, first + blocks * (c + 1) / kChunks, network,
                workspaces_[static_cast<std::size_t>(thread)], chunks_[used_chunks_ + c], backward);
    });
    used_chunks_ += kChunks;
  }
  ObjectiveValue value;
  value.loss = by_logarithm;
  value.state_rmse.assign(structure_->state_mean.size(), 0.0);
  for (const ChunkResult& chunk : results()) {
    value.loss += chunk.loss;
    for (std::size_t i = 0; i < value.state_rmse.size(); ++i)
      value.state_rmse[i] += (chunk.squares[i] + chunk.settled_squares[i]) / blocks_.total_weight();
  }
  for (double& mean_square : value.state_rmse) {
    value.rmse += mean_square;
    mean_square = std::sqrt(mean_square);
  }
  value.rmse = std::sqrt(value.rmse);
  const double settled = blocks_.settled_weight(), transient = blocks_.total_weight() - settled;
  if (settled > 0.0 && transient > 0.0) {
    value.transient_rmse = rmse_of(&ChunkResult::squares, transient);
    value.settled_rmse = rmse_of(&ChunkResult::settled_squares, settled);
  }
  for (int r = 0; r < structure_->latent.learned; ++r) {
    const double lambda = eigenvalues[static_cast<std::size_t>(r)];
    for_each_loss<EigenvalueLoss>(*loss_, [&](const EigenvalueLoss& term, double weight) {
      term.add(weight * blocks_.horizon_s(), lambda, value.loss);
    });
  }
  if (backward) add_gradients(parameters, gradient);
  return value;
}

/// Adds the chunks' gradients of the networks, and the gradient of the latent system by its own backward pass.
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
        total += term.add(weight * blocks_.horizon_s(), lambda, unused) * lambda;
      });
      for (const ChunkResult& chunk : results()) total += chunk.eigenvalues[at] * lambda;
    }
    for (const SegmentGroup& group : groups) total += group.gradient[at];
    gradient[at] = static_cast<float>(total);
  }
}

}  // namespace nlo::trainer
