// SPDX-License-Identifier: MIT
// An observer as training sees it: what its latent system is, what T* reads, where the parameters lie.
// Flat parameters: [latent system | T* | T].
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "trainer/nn/network.h"
#include "trainer/sensitivity/linear_latent.h"

namespace nlo::trainer {

enum class StructureKind {
  kKkl,         ///< (16): z' = D z + F y, x_hat = T*(z)
  kDrivenKkl,   ///< (24)-(25): the same with T beside T*; flown with phi(z) u
  kLuenberger,  ///< (15): x_hat' = A x_hat + g_hat(x_hat) + G (y - C x_hat)
  kGeneral,     ///< (11): z' = F(z, y), x_hat = G(z)
};

/// One input of T*: latent row plus output_gain times an output (either may be absent: -1), then normalised.
struct Feature {
  int latent = -1;
  int output = -1;
  float output_gain = 0.0F;
  float mean = 0.0F, scale = 1.0F;
};

/// The known part of (15): A n_x x n_x, C n_y x n_x, and the gain G n_x x n_y that makes A - G C Hurwitz.
struct LinearPart {
  Eigen::MatrixXd state_matrix, output_matrix, gain;
};

/// Mean and scale of each input of a network.
struct Normalisation {
  std::vector<double> mean, scale;
};

/// A network over normalised inputs, for g_hat of (15) and F of (11).
struct DynamicsNetwork {
  NetworkShape shape;
  Normalisation inputs;
};

struct ObserverStructure {
  StructureKind kind = StructureKind::kKkl;
  int outputs = 0;                  ///< n_y
  LatentShape latent;               ///< (11): of the linear system that F starts as; (15): its rows are the states
  std::vector<double> eigenvalues;  ///< initial, n_z, in row order; clocks stay
  LinearPart known;                 ///< (15)
  DynamicsNetwork dynamics;         ///< (11), (15)

  std::vector<Feature> features;  ///< of T* or G; empty for (15), whose latent state is the estimate
  std::vector<float> state_mean, state_scale;
  NetworkShape network;  ///< T* or G

  std::optional<NetworkShape> forward_map;  ///< T, over (x - state_mean) / state_scale
  std::vector<float> latent_mean, latent_scale;

  bool is_kkl() const { return kind == StructureKind::kKkl || kind == StructureKind::kDrivenKkl; }
  int dynamics_parameters() const { return is_kkl() ? latent.learned : dynamics.shape.parameters; }
  int parameters() const {
    return dynamics_parameters() + network.parameters + (forward_map ? forward_map->parameters : 0);
  }
  /// Complex pairs among the eigenvalues of D.
  int pairs() const {
    int count = 0;
    for (const Mode& mode : latent.modes) count += is_kkl() && mode.pair ? 1 : 0;
    return count;
  }
  /// Eigenvalues of D at these parameters, the clocks' included; none for structures without D.
  std::vector<double> eigenvalues_at(const float* parameters) const;
};

/// The feature is a row exp(-t / tau) of the latent system, which no output drives.
inline bool is_clock(const ObserverStructure& structure, const Feature& feature) {
  for (const Mode& mode : structure.latent.modes)
    if (mode.output < 0 && mode.row == feature.latent) return true;
  return false;
}

}  // namespace nlo::trainer
