// SPDX-License-Identifier: MIT
// Converts the states and outputs of a plant to the channels of a Dataset, like the columns of a log: some states are
// estimated, and some angles are given as sine and cosine.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

class PlantChannels {
 public:
  /// Throws KeyError with a key of [plant] for lists of the wrong length, the sine of a state that is not an angle, an
  /// unknown state, an unknown name in [plant] even, and a state named twice.
  PlantChannels(const PlantConfig& config, const Plant& plant);

  const std::vector<Channel>& states() const { return states_.channels; }
  const std::vector<Channel>& outputs() const { return outputs_.channels; }

  /// Returns true if the channels are those of the plant: every state in its place, no angle as sine and cosine.
  bool plain() const { return states_.plain && outputs_.plain; }
  bool all_states() const;  ///< true if each state is among the channels, in any form

  /// Returns the channels (one column per sample) of the states x of the plant, n_x x N.
  Eigen::MatrixXd states(const Eigen::MatrixXd& x) const { return encoded(states_, x); }

  /// Returns y of the plant from the channels of its outputs. An angle from its sine and cosine is within half a turn
  /// of 0.
  Eigen::MatrixXd plant_outputs(const Eigen::MatrixXd& channels) const;

  /// Converts a dataset that holds the states and outputs of the plant to the channels.
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
  /// Returns d/dt of the channels for states x with derivatives f.
  Eigen::MatrixXd derivatives(const Eigen::MatrixXd& x, const Eigen::MatrixXd& f) const;

  Side states_, outputs_, unestimated_;
  Eigen::Index plant_states_ = 0, plant_outputs_ = 0;
};

}  // namespace nlo::trainer
