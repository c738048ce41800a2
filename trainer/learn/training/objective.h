// SPDX-License-Identifier: MIT
// The cost (9) of an observer over sampled trajectories, and its gradient. It runs the latent system over the segments,
// runs T* and the loss terms over blocks of samples, and propagates the cotangents of z back through the latent system.
// The same code serves every structure, full batches and random samples. These differ only in the segments and ticks
// that are drawn.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/learn/losses/estimate_block.h"
#include "trainer/learn/losses/loss_registry.h"
#include "trainer/learn/losses/map_block.h"
#include "trainer/learn/losses/sample_rows.h"
#include "trainer/learn/training/blocks.h"
#include "trainer/rollout/rollout.h"
#include "trainer/structures/structure.h"

namespace nlo::trainer {

/// The cost that is minimised, and the root mean square of the state error, normalised if the loss is.
struct ObjectiveValue {
  double loss = 0.0;
  double rmse = 0.0;                    ///< sqrt(mean |x - x_hat|^2), each state in the units of the loss
  std::vector<double> state_rmse = {};  ///< RMSE of each state, n_x
  /// RMSE of each state before and after the end of the transient, n_x. Empty if no end is set, or if all samples are
  /// on one side of it.
  std::vector<double> transient_rmse = {}, settled_rmse = {};
};

/// Returns true if the error of a state is more than 2 % larger than that of a filter, over whole runs or in the
/// geometric mean of the errors before and after the end of the transient. Over whole runs the transient dominates, so
/// that the settled error could double. An error below 0.001 deviations counts as 0.001 deviations.
///   deviations  n_x, standard deviations of the states in the units of the errors
bool is_behind(const ObjectiveValue& observer, const ObjectiveValue& filter, const std::vector<double>& deviations);

class Objective {
 public:
  /// `structure` may still be normalised before the first evaluation. The PDE residual needs f in the data, at samples
  /// or at collocation points.
  Objective(const Experiment& experiment, const ObserverStructure& structure, const TrainingData& data,
            ThreadPool& pool);

  /// Returns the cost and its gradient for the segments, noise and ticks that this step draws.
  ///   gradient  n parameters; null: only the value is computed
  ObjectiveValue evaluate(const float* parameters, long step, float* gradient);

  /// Returns sqrt(mean |x - x_hat|^2) over whole runs and all samples, with the same noise in every call. If the loss
  /// is normalised, so is the result; otherwise the state with the largest values alone would decide which model is
  /// best.
  double validate(const float* parameters) { return validation(parameters).rmse; }
  /// Sets the end of the transient [sample periods since the start], so that validation() also returns the errors
  /// before and after it.
  void split_validation_at(double settled_from) { blocks_.split_at(settled_from); }
  ObjectiveValue validation(const float* parameters);

  Rollout& rollout() { return rollout_; }
  /// Rolls out the segments of flight_segments() with noise, with these parameters of the latent system. The scales,
  /// the start of the linear path and the domain are computed from the result.
  const Rollout& roll_out_flight(const float* parameters);
  /// Rolls out the draw of training step `step`. No training step uses a negative number.
  const Rollout& roll_out_draw(const float* parameters, long step);
  /// Rolls out the runs of validate(): whole runs, then the same runs with each sensor missing that may fail.
  const Rollout& roll_out_runs(const float* parameters);

 private:
  struct ChunkResult {
    double loss = 0.0;
    std::vector<double> squares, settled_squares;  ///< sums over transient and over settled blocks, n_x
    std::vector<float> gradient;                   ///< gradient of T* and T
    std::vector<double> eigenvalues;  ///< gradient of the PDE residual with respect to the eigenvalues, n_z
  };
  /// Temporary storage of one thread.
  struct Workspace {
    Workspace(const ObserverStructure& structure, const LossConfig& loss);
    EstimateBlock estimate;
    std::optional<MapBlock<float, kBlock>> maps;  ///< set if T is trained, like the next two
    std::optional<SampleRows> rows;
    std::vector<float> cotangent_z;  ///< n_z rows
  };

  void prepare(const float* parameters);
  void roll_out(const float* parameters, const std::vector<Segment>& segments, Purpose purpose, long step);

  /// Returns true if the latest losses train T.
  bool trains_maps() const { return structure_->forward_map && needs_forward_map(*loss_); }
  void prepare_networks(const float* network, const std::vector<double>& eigenvalues, bool backward);
  double share_by_logarithm(const float* network);
  void run_chunk(std::size_t begin, std::size_t end, const float* network, Workspace& workspace, ChunkResult& result,
                 bool backward);
  ObjectiveValue accumulate(const float* parameters, float* gradient);
  /// Returns the root mean square of each state over the blocks that `squares` counts, n_x.
  std::vector<double> rmse_of(std::vector<double> ChunkResult::*squares, double weight) const;
  void run_block(const Block& block, const float* network, Workspace& workspace, ChunkResult& result, bool backward);
  void estimate_losses(const Block& block, const float* network, Workspace& workspace, ChunkResult& result,
                       bool backward);
  void map_losses(const Block& block, Workspace& workspace, ChunkResult& result, bool backward);
  void equation_losses(const MapSamples<float>& samples, Workspace& workspace, ChunkResult& result,
                       bool backward) const;
  void add_gradients(const float* parameters, float* gradient);
  std::span<const ChunkResult> results() const { return std::span(chunks_).first(used_chunks_); }

  const Experiment* experiment_;
  const ObserverStructure* structure_;
  const TrainingData* data_;
  ThreadPool* pool_;
  std::unique_ptr<LatentDynamics> dynamics_;  ///< made at first use, because the structure is normalised before
  Rollout rollout_;
  const LossConfig* loss_ = nullptr;  ///< losses of the latest draw
  Blocks blocks_;
  std::vector<ChunkResult> chunks_;
  std::size_t used_chunks_ = 0;        ///< by the latest accumulate()
  std::vector<Workspace> workspaces_;  // one per thread
  std::vector<float> transposed_;
};

}  // namespace nlo::trainer
