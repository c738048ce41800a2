// SPDX-License-Identifier: MIT
// Base of the KKL observers: z' = D z + F y, whose eigenvalues are the parameters of the latent system, and T*.
#pragma once

#include "trainer/structures/trainable_structure.h"

namespace nlo::trainer {

/// Keys of [observer] that only structure kkl has.
struct KklConfig {
  double saturation = 0.0;  ///< T* reads z up to this many half ranges beyond its domain; 0: no limit
  ClockProductSet clock_products = ClockProductSet::kNone;
};

class KklFamily : public TrainableStructure {
 public:
  void check(const Experiment& experiment, const ChannelCounts& channels) const override;

  bool has_eigenvalues() const override { return true; }
  bool follows_unwrapped_angles() const override { return true; }

  void vary(Experiment& experiment, Draws& draws) const override;

  void make(const Experiment& experiment, ObserverStructure& structure) const override;
  std::vector<float> initial_dynamics(const ObserverStructure& structure, const Experiment& experiment) const override;
  std::unique_ptr<OdeDynamics<float>> lanes(const ObserverStructure& structure) const override;
  std::unique_ptr<OdeDynamics<double>> lanes_in_double(const ObserverStructure& structure) const override;
  /// Returns the exact filter, or lanes() by RK4 if [training] gradient is backprop or adjoint.
  std::unique_ptr<LatentDynamics> latent_dynamics(const Experiment& experiment, const ObserverStructure& structure,
                                                  const std::vector<double>& steps_s, int threads) const override;

 protected:
  /// Returns the trained D, F and T*. Sets the initial values of the clocks in the model, which must already have its
  /// channels.
  static codegen::Kkl kkl_of(const ObserverStructure& structure, const float* parameters,
                             const ObserverConfig& observer, codegen::Model& model);
};

}  // namespace nlo::trainer
