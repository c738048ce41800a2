// SPDX-License-Identifier: MIT
// Runs a latent system over groups of trajectories, forward, and backward for its gradient. The objective uses the
// dynamics of a structure only through this interface.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "trainer/gradients/sensitivity/ode_latent.h"

namespace nlo::trainer {

class LatentDynamics {
 public:
  explicit LatentDynamics(int rows) : rows_(rows) {}
  virtual ~LatentDynamics() = default;
  LatentDynamics(const LatentDynamics&) = delete;
  LatentDynamics& operator=(const LatentDynamics&) = delete;

  int rows() const { return rows_; }  ///< n_z

  /// Reads the parameters of the latent system. Call it before forward(), once for each set of parameters.
  virtual void prepare(const float* parameters) = 0;

  /// Fills group.latent from group.readings. `thread` selects the scratch memory.
  virtual void forward(SegmentGroup& group, int thread) = 0;

  /// Returns true if forward() accepts a group that continues longer segments.
  virtual bool continues() const { return false; }

  /// Fills group.gradient, dl/d(parameters), from group.cotangent.
  virtual void backward(SegmentGroup& group, int thread) = 0;

 private:
  int rows_;
};

/// The filter of linear_latent.h.
class LinearLatent final : public LatentDynamics {
 public:
  /// eigenvalues: initial eigenvalues, n_z. steps_s: the distinct steps of the data. fixed: true if the eigenvalues are
  /// not learned; their coefficients (one set for each distinct step) are then computed only once.
  LinearLatent(LatentShape shape, std::vector<double> eigenvalues, const std::vector<double>& steps_s, bool fixed);

  void prepare(const float* parameters) override;
  void forward(SegmentGroup& group, int thread) override;
  bool continues() const override { return true; }
  void backward(SegmentGroup& group, int thread) override;

 private:
  LatentShape shape_;
  std::vector<double> eigenvalues_;
  const std::vector<double>& steps_s_;
  bool fixed_, prepared_ = false;
  Coefficients coefficients_;
};

/// Runge-Kutta roll-outs of ode_latent.h, RK4 at the sample period.
class OdeLatent final : public LatentDynamics {
 public:
  using Factory = std::function<std::unique_ptr<OdeDynamics<float>>()>;

  /// make: returns the dynamics for one of `threads`. shape: readings and modes of the latent system. gradient:
  /// adjoint, or else backprop.
  OdeLatent(const Factory& make, int threads, const LatentShape& shape, LatentGradient gradient,
            const std::vector<double>& steps_s);

  void prepare(const float* parameters) override;
  void forward(SegmentGroup& group, int thread) override;
  void backward(SegmentGroup& group, int thread) override;

 private:
  /// Returns the group as a run. The steps of jittered data are gathered in `steps`.
  OdeRun<float> run_of(SegmentGroup& group, std::vector<float>& steps) const;

  std::vector<std::unique_ptr<OdeDynamics<float>>> dynamics_;  // one per thread
  Hold hold_;
  int commands_from_;
  bool by_adjoint_;
  const std::vector<double>& steps_s_;
  float step_s_;
  std::vector<float> parameters_;
};

}  // namespace nlo::trainer
