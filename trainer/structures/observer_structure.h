// SPDX-License-Identifier: MIT
// An observer in training: its latent system, the features of T*, the layout of the parameters.
// Flat parameters: [latent system | T* | T].
#pragma once

#include <optional>
#include <vector>

#include "trainer/base/by_type.h"
#include "trainer/gradients/nn/network_shape.h"
#include "trainer/gradients/sensitivity/linear_latent.h"

namespace nlo::trainer {

class TrainableStructure;

/// One input of T*: latent row plus reading_gain times a reading, an output or an input that the observer reads (either
/// may be absent: -1), then normalised, then multiplied by a clock (absent: -1).
struct Feature {
  int latent = -1;
  int reading = -1;
  float reading_gain = 0.0F;
  float mean = 0.0F, scale = 1.0F;
  int clock = -1;    ///< latent row exp(-t / tau)
  int without = -1;  ///< the feature that this one is without its clock; they have the same mean and scale
};

/// u = (z + gain y - mean) / scale in numbers of one precision. `z` and `y` point at the feature's own latent row and
/// reading at one sample; null where the feature has none. A clock multiplies the result.
template <class Scalar>
struct FeatureFormula {
  Scalar mean, gain, inverse;

  explicit FeatureFormula(const Feature& feature)
      : mean(static_cast<Scalar>(feature.mean)),
        gain(static_cast<Scalar>(feature.reading_gain)),
        inverse(Scalar(1) / static_cast<Scalar>(feature.scale)) {}

  /// z + gain y, on top of `from`.
  Scalar sum(Scalar from, const Scalar* z, const Scalar* y) const {
    if (z != nullptr) from += *z;
    if (y != nullptr) from += gain * *y;
    return from;
  }
  Scalar normalised(const Scalar* z, const Scalar* y) const { return sum(-mean, z, y) * inverse; }
  /// Before mean and scale are known.
  Scalar raw(const Scalar* z, const Scalar* y) const { return sum(Scalar(0), z, y); }
};

/// Mean and scale of each input of a network.
struct Normalisation {
  std::vector<double> mean, scale;
};

/// A network over normalised inputs, within a latent system.
struct DynamicsNetwork {
  NetworkShape shape;
  Normalisation inputs;
};

struct ObserverStructure {
  const TrainableStructure* module = nullptr;  ///< the structure (structures/trainable_structure.h)
  int readings = 0;                            ///< n_r: outputs, inputs that are read, stalenesses
  int inputs = 0;                              ///< inputs among them
  int failing = 0;                             ///< stalenesses among them, of sensors that may fail, behind the inputs
  int outputs() const { return readings - inputs - failing; }  ///< n_y
  LatentShape latent;               ///< its learned rows are parameters; none where there is no D
  std::vector<double> eigenvalues;  ///< initial, n_z, in row order; clocks stay
  DynamicsNetwork dynamics;         ///< within the latent system; without one it has no parameters
  ByType own;                       ///< the module's own values

  int axes = 1;  ///< features and states are vectors of so many components; T* is to be the same for each component
  bool centred = false;           ///< features and states have no mean: T* is to have no preferred place
  std::vector<Feature> features;  ///< features of T*; empty if the latent state is the estimate
  std::vector<float> state_mean, state_scale;
  NetworkShape network;  ///< T*

  std::optional<NetworkShape> forward_map;  ///< T, over (x - state_mean) / state_scale
  std::vector<float> latent_mean, latent_scale;

  /// Parameters of the latent system: its eigenvalues, then its network.
  int dynamics_parameters() const { return latent.learned + dynamics.shape.parameters; }
  int parameters() const {
    return dynamics_parameters() + network.parameters + (forward_map ? forward_map->parameters : 0);
  }
  /// Complex pairs among the eigenvalues of D.
  int pairs() const {
    int count = 0;
    for (const Mode& mode : latent.modes) count += latent.learned > 0 && mode.pair ? 1 : 0;
    return count;
  }
  /// Eigenvalues of D at these parameters, the clocks' included; none for structures without D.
  std::vector<double> eigenvalues_at(const float* parameters) const;
};

/// The feature is a row exp(-t / tau) of the latent system, which nothing drives.
inline bool is_clock(const ObserverStructure& structure, const Feature& feature) {
  for (const Mode& mode : structure.latent.modes)
    if (mode.reading < 0 && mode.row == feature.latent) return true;
  return false;
}

}  // namespace nlo::trainer
