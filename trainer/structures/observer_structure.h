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

/// One input of T*: a latent row plus reading_gain times a reading (an output or an input that the observer reads),
/// then normalised, then multiplied by a clock. Row, reading and clock are -1 if absent.
struct Feature {
  int latent = -1;
  int reading = -1;
  float reading_gain = 0.0F;
  float mean = 0.0F, scale = 1.0F;
  int clock = -1;    ///< latent row exp(-t / tau)
  int without = -1;  ///< the same feature without its clock; both have the same mean and scale
};

/// Computes u = (z + gain y - mean) / scale in numbers of one precision. `z` and `y` point to the feature's latent row
/// and reading at one sample; null if it has none. A clock multiplies the result.
template <class Scalar>
struct FeatureFormula {
  Scalar mean, gain, inverse;

  explicit FeatureFormula(const Feature& feature)
      : mean(static_cast<Scalar>(feature.mean)),
        gain(static_cast<Scalar>(feature.reading_gain)),
        inverse(Scalar(1) / static_cast<Scalar>(feature.scale)) {}

  /// Returns `from` + z + gain y.
  Scalar sum(Scalar from, const Scalar* z, const Scalar* y) const {
    if (z != nullptr) from += *z;
    if (y != nullptr) from += gain * *y;
    return from;
  }
  Scalar normalised(const Scalar* z, const Scalar* y) const { return sum(-mean, z, y) * inverse; }
  /// Returns the feature before mean and scale are known.
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
  const TrainableStructure* module = nullptr;                  ///< the structure (structures/trainable_structure.h)
  int readings = 0;                                            ///< n_r: outputs, inputs that are read, stalenesses
  int inputs = 0;                                              ///< inputs among them
  int failing = 0;                                             ///< number of stalenesses, which are the last readings
  int outputs() const { return readings - inputs - failing; }  ///< n_y
  LatentShape latent;               ///< latent system; its learned rows are parameters; empty if there is no D
  std::vector<double> eigenvalues;  ///< initial eigenvalues, n_z, in row order; those of clocks do not change
  DynamicsNetwork dynamics;         ///< within the latent system; has no parameters if there is none
  ByType own;                       ///< values that only the module of the structure uses

  int axes = 1;  ///< number of components of each vector in features and states; T* is the same for every component
  bool centred = false;  ///< true: features and states keep their origin (mean 0), so that T* prefers no direction
  std::vector<Feature> features;  ///< features of T*; empty if the latent state is the estimate
  std::vector<float> state_mean, state_scale;
  NetworkShape network;  ///< T*

  std::optional<NetworkShape> forward_map;  ///< T, over (x - state_mean) / state_scale; empty if there is none
  std::vector<float> latent_mean, latent_scale;

  /// Returns the number of parameters of the latent system: its eigenvalues, then its network.
  int dynamics_parameters() const { return latent.learned + dynamics.shape.parameters; }
  int parameters() const {
    return dynamics_parameters() + network.parameters + (forward_map ? forward_map->parameters : 0);
  }
  /// Returns the number of complex pairs among the eigenvalues of D.
  int pairs() const {
    int count = 0;
    for (const Mode& mode : latent.modes) count += latent.learned > 0 && mode.pair ? 1 : 0;
    return count;
  }
  /// Returns the eigenvalues of D for these parameters, including those of clocks; empty for structures without D.
  std::vector<double> eigenvalues_at(const float* parameters) const;
};

/// Returns true if the feature is a row exp(-t / tau) of the latent system, which has no input.
inline bool is_clock(const ObserverStructure& structure, const Feature& feature) {
  for (const Mode& mode : structure.latent.modes)
    if (mode.reading < 0 && mode.row == feature.latent) return true;
  return false;
}

}  // namespace nlo::trainer
