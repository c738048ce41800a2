// SPDX-License-Identifier: MIT
// The cost (9) of an observer over sampled trajectories, and its gradient: run the latent system over the segments, T*
// and the loss terms over blocks of samples, and pull the cotangents of z back through the latent system. One route for
// every structure, for full batches and random samples; these differ in which segments and ticks are drawn.
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

/// The cost as it is minimised, and the state error as a root: in the states' units, or normalised where the loss is.
struct ObjectiveValue {
  double loss = 0.0;
  double rmse = 0.0;                    ///< sqrt(mean |x - x_hat|^2), each state in the units of the loss
  std::vector<double> state_rmse = {};  ///< n_x, the same of each state
};

class Objective {
 public:
  /// `structure` may still be normalised, before the first evaluation. For the PDE residual the data must hold f: at
  /// its samples or at collocation points.
  Objective(const Experiment& experiment, const ObserverStructure& structure, const TrainingData& data,
            ThreadPool& pool);

  /// Loss and gradient at a step's own draw of segments, noise and ticks.
  ///   gradient  n parameters, or null for the value alone
  ObjectiveValue evaluate(const float* parameters, long step, float* gradient);

  /// sqrt(mean |x - x_hat|^2) over whole runs and all samples, with noise that is the same in every call. Where the
  /// loss is normalised, so is this: else the state of the largest unit alone would choose the model.
  double validate(const float* parameters) { return validation(parameters).rmse; }
  ObjectiveValue validation(const float* parameters);

  Rollout& rollout() { return rollout_; }
  /// Rolls out the segments of flight_segments() at these parameters of the latent system, with noise. The result gives
  /// the scales, the start of the linear path and the domain.
  const Rollout& roll_out_flight(const float* parameters);
  /// Rolls out the draw of training step `step`. No training step uses a negative number.
  const Rollout& roll_out_draw(const float* parameters, long step);
  /// Rolls out the runs of validate(): whole runs, and again with each sensor missing that may fail.
  const Rollout& roll_out_runs(const float* parameters);

 private:
  struct ChunkResult {
    double loss = 0.0;
    std::vector<double> squares;      ///< n_x
    std::vector<float> gradient;      ///< gradient of T* and T
    std::vector<double> eigenvalues;  ///< gradient of the PDE residual by the eigenvalues, n_z
  };
  /// The memory of one thread.
  struct Workspace {
    Workspace(const ObserverStructure& structure, const LossConfig& loss);
    EstimateBlock estimate;
    std::optional<MapBlock<float, kBlock>> maps;  ///< if T is trained, as the next two
    std::optional<SampleRows> rows;
    std::vector<float> cotangent_z;  ///< n_z rows
  };

  void prepare(const float* parameters);
  void roll_out(const float* parameters, const std::vector<Segment>& segments, Purpose purpose, long step);

  /// Whether the losses drawn last train T.
  bool trains_maps() const { return structure_->forward_map && needs_forward_map(*loss_); }
  void prepare_networks(const float* network, const std::vector<double>& eigenvalues, bool backward);
  double share_by_logarithm(const float* network);
  void run_chunk(std::size_t begin, std::size_t end, const float* network, Workspace& workspace, ChunkResult& result,
                 bool backward);
  ObjectiveValue accumulate(const float* parameters, float* gradient);
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
  std::unique_ptr<LatentDynamics> dynamics_;  ///< made at first use: the structure is normalised before that
  Rollout rollout_;
  const LossConfig* loss_ = nullptr;  ///< losses of the latest draw
  Blocks blocks_;
  std::vector<ChunkResult> chunks_;
  std::size_t used_chunks_ = 0;        ///< by the latest accumulate()
  std::vector<Workspace> workspaces_;  // one per thread
  std::vector<float> transposed_;
};

}  // namespace nlo::trainer
