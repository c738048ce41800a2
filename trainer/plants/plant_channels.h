// SPDX-License-Identifier: MIT
// How a plant's states and outputs become the channels of a Dataset, as the columns of a log do: which states are
// estimated, and which angles are given as their sine and cosine.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

class PlantChannels {
 public:
  /// Throws KeyError of a key of [plant]: lists of the wrong length, the sine of a state that is no angle, a state or
  /// an even channel that is not there, a state named twice.
  PlantChannels(const PlantConfig& config, const Plant& plant);

  const std::vector<Channel>& states() const { return states_.channels; }
  const std::vector<Channel>& outputs() const { return outputs_.channels; }

  /// Every state in its place, no angle as sine and cosine: the channels are the plant's own.
  bool plain() const { return states_.plain && outputs_.plain; }
  bool all_states() const;  ///< each is among the channels, in any form

  /// Channels (one column per sample) of the plant's states x, n_x x N.
  Eigen::MatrixXd states(const Eigen::MatrixXd& x) const { return encoded(states_, x); }

  /// y of the plant from the channels of its outputs; an angle from its sine and cosine is within half a turn of 0.
  Eigen::MatrixXd plant_outputs(const Eigen::MatrixXd& channels) const;

  /// The channels of a dataset that holds the plant's own states and outputs.
  void apply(Dataset& dataset) const;

 private:
  enum class Part { kWhole, kSine, kCosine };
  struct Source {
    Eigen::Index row;  ///< row among the plant's states or outputs
    Part part;
    double wrap;
  };
  struct Side {
    std::vector<Channel> channels;
    std::vector<Source> sources;  ///< one per channel
    bool plain = true;
  };

  static void add(Side& side, const Channel& channel, Eigen::Index row, bool sincos);
  static Eigen::MatrixXd encoded(const Side& side, const Eigen::MatrixXd& values);
  /// d/dt of the channels where the states x move at f.
  Eigen::MatrixXd derivatives(const Eigen::MatrixXd& x, const Eigen::MatrixXd& f) const;

  Side states_, outputs_;
  Eigen::Index plant_states_ = 0, plant_outputs_ = 0;
};

}  // namespace nlo::trainer
