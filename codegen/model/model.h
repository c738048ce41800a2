// SPDX-License-Identifier: MIT
// A trained observer as a value: named fields with their shapes, and facts about its training. A model file holds it,
// and an export reads it. All numbers are double; an export rounds each one once, to the scalar of its target.
#pragma once

#include <nlo/latent.h>
#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "codegen/model/error_head_parameters.h"
#include "codegen/model/flight.h"
#include "codegen/model/monitor_parameters.h"
#include "codegen/model/network.h"
#include "codegen/model/sensor_failure_parameters.h"
#include "codegen/model/structures.h"

namespace nlo::codegen {

/// An observer of sampled outputs y with a latent state z: the fields that every structure has, and the part of its own
/// structure, whose equations are in structures/. `hold` is the course of y between samples.
struct Model {
  std::string name;              ///< an identifier: namespace and file name of the export
  std::vector<Channel> outputs;  ///< measured outputs, then computed ones (computed_outputs.h)
  std::vector<Channel> states;

  /// Known inputs u that the observer reads beside y: in the equations of structures/, y then stands for [y; u]. Empty:
  /// none. (A driven_kkl observer, whose inputs act on the estimate, has its own field.)
  std::vector<Channel> inputs = {};
  /// Zero order: u has acted since the last sample (a command). First order: like the outputs.
  Hold input_hold = Hold::kZeroOrder;
  Eigen::VectorXd input_min, input_max;  ///< n_u: range; inputs outside of it are clamped

  /// Outputs that may be missing. Their stalenesses are the last readings: in the equations, y then stands for [y; u;
  /// staleness].
  SensorFailures failures = {};

  double sample_period_s = 0.0;
  Hold hold = Hold::kFirstOrder;   ///< kRk4: a ramp; in a KKL observer stepped by Runge-Kutta
  Eigen::VectorXd initial_latent;  ///< n_z, before the first sample

  Eigen::VectorXd output_min, output_max;  ///< n_y: declared ranges; see flown_ranges.h
  Eigen::VectorXd latent_min, latent_max;  ///< n_z: training domain of z, relative to S y for relative outputs
  /// Saturation (nlo/saturation.h): margin of the box around the domain, in half ranges of the domain; 0: no
  /// saturation.
  double saturation = 0.0;
  bool saturates() const { return saturation != 0.0; }

  Structure structure;

  /// Facts about the training, for readers and for reproduction, in the order in which they are shown: version, seed,
  /// config, data hash, errors ...
  std::vector<std::pair<std::string, std::string>> provenance;

  std::optional<Monitor> monitor = {};  ///< made by `nlo monitor`
  std::optional<ErrorHead> error = {};  ///< none: the model gives no intervals

  Flight flight = {};  ///< without runs: a model made by hand, or by a version that recorded none

  int nx() const { return static_cast<int>(states.size()); }
  int ny() const { return static_cast<int>(outputs.size()); }
  int nz() const { return static_cast<int>(initial_latent.size()); }
  int measured() const;  ///< number of outputs that step() takes: n_y without computed ones
  int nu() const;        ///< number of known inputs that step() takes
  int nr() const {       ///< number of readings: outputs, inputs that are readings, stalenesses
    return ny() + static_cast<int>(inputs.size() + failures.outputs.size());
  }
};

/// A learned map of a model, by its name in the model file.
template <class NetworkType>
struct Named {
  std::string field;  ///< "drive.forward_map"
  NetworkType* network;
  Eigen::Index reads;  ///< number of leading inputs that it uses: n_z of [z; y] if y has no weight
};

// Properties of models of any structure.

/// Returns the name of the structure in model files: "kkl", "driven_kkl", ...
std::string_view structure_name(const Model& model);

/// Returns all learned maps, in the order of the model file.
std::vector<Named<const Network>> networks(const Model& model);
std::vector<Named<Network>> networks(Model& model);

/// Returns the map from z (and y) to the estimate; null if z is the estimate.
const Network* inverse_map(const Model& model);
Network* inverse_map(Model& model);

/// Returns D and F; null if the latent system is not linear.
const LinearLatent* linear_latent(const Model& model);
LinearLatent* linear_latent(Model& model);

/// Returns the known inputs that step() takes.
const std::vector<Channel>& inputs(const Model& model);

/// Returns the outputs that step() takes.
std::vector<Channel> measured_channels(const Model& model);

/// Returns the readings [y; u; staleness] of F and T*, and their ranges, n_r.
std::vector<Channel> readings(const Model& model);
Eigen::VectorXd reading_min(const Model& model);
Eigen::VectorXd reading_max(const Model& model);

/// Returns the same observer without the inputs of a driven structure. Inputs that are readings stay.
Model without_inputs(Model model);

/// Returns true if T* and the domain read this reading only through z - S y: an angle, or one of relative_outputs.
bool is_relative(const Model& model, int reading);

/// Returns true if T* saturates and an output is relative.
bool saturates_relative(const Model& model);

}  // namespace nlo::codegen
