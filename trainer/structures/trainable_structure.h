// SPDX-License-Identifier: MIT
// The interface of an observer structure to the trainer. Each structure is one class in one file, and structure_table.h
// lists them. No other code depends on which structure an observer has.
//
// To add a structure: add a file with its class and its instance to this folder, and a line to structure_table.cpp.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string_view>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/rollout/rollout.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

template <class Section>
struct Key;
class Draws;

/// Numbers of channels of an observer. An angle as sine and cosine counts as two.
struct ChannelCounts {
  int states = 0, outputs = 0;
  int inputs = 0;       ///< inputs of the plant or of the logs
  int read_inputs = 0;  ///< inputs that the observer reads beside the outputs
  std::vector<codegen::Channel> output_channels = {}, read_input_channels = {}, state_channels = {};
};

class TrainableStructure {
 public:
  TrainableStructure() = default;
  virtual ~TrainableStructure() = default;
  TrainableStructure(const TrainableStructure&) = delete;
  TrainableStructure& operator=(const TrainableStructure&) = delete;

  virtual std::string_view name() const = 0;  ///< value of [observer] structure

  /// Returns the keys of [observer] that only this structure has: own_key() of a struct in ObserverConfig::own.
  virtual std::vector<Key<ObserverConfig>> own_keys() const;

  /// Throws KeyError for keys of an experiment that do not fit this structure.
  virtual void check(const Experiment& experiment, const ChannelCounts& channels) const = 0;

  // Properties of the structure.
  /// Returns true if the structure has a D with eigenvalues, which parameters, penalties and constants use.
  virtual bool has_eigenvalues() const { return false; }
  /// Returns true if T* may read products of its features with clocks (KklConfig::clock_products).
  virtual bool may_read_clock_products() const { return false; }
  virtual bool has_dynamics_network() const { return false; }
  virtual bool learns_to_average_noise() const { return false; }  ///< without noise in training it loses accuracy
  virtual bool has_known_equations() const { return false; }  ///< it steps the equations of the plant, as a filter does
  virtual bool has_inverse_map() const { return true; }       ///< false: z is the estimate
  virtual bool flies_forward_map() const { return false; }
  virtual bool flies_inputs() const { return false; }            ///< inputs act on its estimate through g of the plant
  virtual bool reads_inputs() const { return !flies_inputs(); }  ///< it reads known inputs beside the outputs
  virtual bool follows_unwrapped_angles() const { return false; }  ///< z - y does not change when y turns

  // Candidates of nlo train --auto (app/sweep/search.h).

  /// Turns an experiment of another structure into one of this structure, with suitable settings. The sections that all
  /// structures share change as little as possible. Returns false if the structure needs information from the user.
  virtual bool adopt(Experiment&, double /*sample_period_s*/) const { return false; }

  /// Varies the structure's own settings, such as eigenvalues or units.
  virtual void vary(Experiment&, Draws&) const {}

  /// Returns the sensors that may fail, and the values to which they fade, from the training data.
  virtual codegen::SensorFailures failures(const Experiment&, const Dataset&) const { return {}; }

  /// Makes the structure of an experiment for the channels of a dataset, without the parts that all structures have
  /// (structure.cpp).
  virtual void make(const Experiment& experiment, ObserverStructure& structure) const = 0;

  /// Sets the means and scales of the inputs of a network within the latent system.
  virtual void normalise_dynamics(ObserverStructure&, const TrainingData&, ThreadPool&) const {}

  /// Returns the number of positive constants of the latent system that are tuned before the first step of the training
  /// (tune_constants.h), such as the noise variances of a filter. Most structures have none. The search also starts
  /// with the first constant multiplied by 100 and by 10,000.
  virtual int tuned_constants(const ObserverStructure&) const { return 0; }
  virtual void multiply_constants(ObserverStructure&, const Eigen::VectorXd& /*factors*/) const {}

  /// Returns the row of z that estimates state `state` before any training, so that T* starts as a copy of this row;
  /// -1: there is none.
  virtual int estimate_row(const ObserverStructure&, int /*state*/) const { return -1; }

  /// Returns the initial parameters of the latent system.
  virtual std::vector<float> initial_dynamics(const ObserverStructure& structure,
                                              const Experiment& experiment) const = 0;

  /// Returns the right-hand side of the latent system for RK4 in float, or null if the latent system is not a
  /// differential equation. lanes_in_double() is for tests of gradients.
  virtual std::unique_ptr<OdeDynamics<float>> lanes(const ObserverStructure&) const { return nullptr; }
  virtual std::unique_ptr<OdeDynamics<double>> lanes_in_double(const ObserverStructure&) const { return nullptr; }

  /// Replaces parameters by the nearest ones that the structure allows, after each step of the optimiser and of the
  /// average. Most structures allow all parameters.
  virtual void constrain(const ObserverStructure&, float* /*parameters*/) const {}

  /// Returns the forward and backward passes of the latent system for training. By default, these are lanes() by
  /// Runge-Kutta.
  ///   steps_s  the distinct steps of the data, which must outlive the result
  virtual std::unique_ptr<LatentDynamics> latent_dynamics(const Experiment& experiment,
                                                          const ObserverStructure& structure,
                                                          const std::vector<double>& steps_s, int threads) const;

  /// Fills the structure's own parts of a model that has names, channels and sizes.
  virtual void to_model(const ObserverStructure& structure, const float* parameters, const Experiment& experiment,
                        const Dataset& dataset, codegen::Model& model) const = 0;

  /// Adds the parts that follow from the ranges of the model.
  virtual void complete(const ObserverStructure&, codegen::Model&) const {}
};

}  // namespace nlo::trainer
