// SPDX-License-Identifier: MIT
// The interface of an observer structure to the trainer. Each structure is one class in one file, and structure_table.h
// lists them. No other code asks which structure an observer has.
//
// To add a structure: a file in this folder with its class and its instance, a line in structure_table.cpp.
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

/// How many channels an observer has, an angle as sine and cosine counted as two.
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

  virtual std::string_view name() const = 0;  ///< in [observer] structure

  /// Keys of [observer] that this structure alone has: own_key() of a struct in ObserverConfig::own.
  virtual std::vector<Key<ObserverConfig>> own_keys() const;

  /// Throws KeyError for keys of an experiment that do not fit this structure.
  virtual void check(const Experiment& experiment, const ChannelCounts& channels) const = 0;

  // Its parts.
  /// Whether it has eigenvalues of a D, for parameters, penalties and constants.
  virtual bool has_eigenvalues() const { return false; }
  /// T* may read products of its features with clocks (KklConfig::clock_products).
  virtual bool may_read_clock_products() const { return false; }
  virtual bool has_dynamics_network() const { return false; }
  virtual bool learns_to_average_noise() const { return false; }  ///< it loses accuracy where there is none
  virtual bool has_known_equations() const { return false; }      ///< it steps those of the plant, as a filter does
  virtual bool has_inverse_map() const { return true; }           ///< else z is the estimate
  virtual bool flies_forward_map() const { return false; }
  virtual bool flies_inputs() const { return false; }              ///< they act on its estimate, by g of the plant
  virtual bool reads_inputs() const { return !flies_inputs(); }    ///< beside the outputs, where they are known
  virtual bool follows_unwrapped_angles() const { return false; }  ///< z - y never sees a turn of y

  // Candidates of nlo train --auto (app/sweep/search.h).

  /// Turns an experiment of another structure into one of this, with settings that suit it; the sections that all
  /// structures share stay as far as they can. False if the structure needs information from the user.
  virtual bool adopt(Experiment&, double /*sample_period_s*/) const { return false; }

  /// Varies the structure's own settings: eigenvalues, units.
  virtual void vary(Experiment&, Draws&) const {}

  /// Sensors that may fail, with where they rest in the training data.
  virtual codegen::SensorFailures failures(const Experiment&, const Dataset&) const { return {}; }

  /// The structure of an experiment, for the channels of a dataset: without the common parts of every structure
  /// (structure.cpp).
  virtual void make(const Experiment& experiment, ObserverStructure& structure) const = 0;

  /// Sets the means and scales of the inputs of a network within the latent system.
  virtual void normalise_dynamics(ObserverStructure&, const TrainingData&, ThreadPool&) const {}

  /// Number of positive constants of the latent system that are tuned before the first step of the training
  /// (tune_constants.h), such as the noise variances of a filter. Most structures have none. The search also
  /// starts from the first one a hundred and ten thousand times as large.
  virtual int tuned_constants(const ObserverStructure&) const { return 0; }
  virtual void multiply_constants(ObserverStructure&, const Eigen::VectorXd& /*factors*/) const {}

  /// The row of z that estimates state `state` before any training, so that T* begins as this row. -1: there is none.
  virtual int estimate_row(const ObserverStructure&, int /*state*/) const { return -1; }

  /// Initial parameters of the latent system.
  virtual std::vector<float> initial_dynamics(const ObserverStructure& structure,
                                              const Experiment& experiment) const = 0;

  /// The right-hand side of its latent system, for the general route; in double for tests of gradients. Null: the
  /// latent system is no differential equation.
  virtual std::unique_ptr<OdeDynamics<float>> lanes(const ObserverStructure&) const { return nullptr; }
  virtual std::unique_ptr<OdeDynamics<double>> lanes_in_double(const ObserverStructure&) const { return nullptr; }

  /// Turns parameters into the nearest that the structure allows, after each step of the optimiser and of the average
  /// them. Most allow all.
  virtual void constrain(const ObserverStructure&, float* /*parameters*/) const {}

  /// How training runs the latent system forwards and back; unless a structure knows better, lanes() by Runge-Kutta.
  ///   steps_s  the distinct steps of the data, which outlive the result
  virtual std::unique_ptr<LatentDynamics> latent_dynamics(const Experiment& experiment,
                                                          const ObserverStructure& structure,
                                                          const std::vector<double>& steps_s, int threads) const;

  /// Fills the structure's own parts of a model that has names, channels and sizes.
  virtual void to_model(const ObserverStructure& structure, const float* parameters, const Experiment& experiment,
                        const Dataset& dataset, codegen::Model& model) const = 0;

  /// Adds the parts that follow from the model's ranges.
  virtual void complete(const ObserverStructure&, codegen::Model&) const {}
};

}  // namespace nlo::trainer
