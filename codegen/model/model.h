// SPDX-License-Identifier: MIT
// A trained observer as a value: named, shaped fields with their provenance. What a model file holds, what an export
// reads. All numbers are double here; an export rounds each of them once, to the scalar of its target.
#pragma once

#include <nlo/latent.h>
#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "codegen/model/error_head.h"
#include "codegen/model/flight.h"
#include "codegen/model/monitor.h"
#include "codegen/model/network.h"
#include "codegen/model/sensor_failures.h"
#include "codegen/model/structures.h"

namespace nlo::codegen {

/// An observer of sampled outputs y with a latent state z: what every structure has, and the structure's own part,
/// whose equations stand in structures/. `hold` says how y runs between samples.
struct Model {
  std::string name;              ///< an identifier: namespace and file name of what is exported
  std::vector<Channel> outputs;  ///< those that are computed (computed_outputs.h) behind those that are measured
  std::vector<Channel> states;

  /// Known inputs u that the observer reads beside y: where an equation of structures/ says y, it means [y; u]. Empty:
  /// none. (A driven_kkl observer, on whose estimate u acts, has inputs of its own.)
  std::vector<Channel> inputs = {};
  /// Zero order: the u given has acted since the last sample (a command); first order: it runs as the outputs do.
  Hold input_hold = Hold::kZeroOrder;
  Eigen::VectorXd input_min, input_max;  ///< n_u: inputs outside are clamped

  /// Outputs that may be missing; how stale each is ends the readings: y in an equation is [y; u; staleness] then.
  SensorFailures failures = {};

  double sample_period_s = 0.0;
  Hold hold = Hold::kFirstOrder;   ///< kRk4: a ramp (KKL: by one Runge-Kutta step)
  Eigen::VectorXd initial_latent;  ///< n_z, before the first sample

  Eigen::VectorXd output_min, output_max;  ///< n_y: declared ranges; see flown_ranges.h
  Eigen::VectorXd latent_min, latent_max;  ///< n_z: training domain of z, relative to S y for relative outputs
  /// T* follows z this many half ranges beyond the domain and no further (nlo/saturation.h). 0: wherever z goes.
  double saturation = 0.0;
  bool saturates() const { return saturation != 0.0; }

  Structure structure;

  /// Facts for the reader and for reproduction, in the order they are shown: version, seed, config, data hash,
  /// errors...
  std::vector<std::pair<std::string, std::string>> provenance;

  std::optional<Monitor> monitor = {};  ///< where nlo monitor has made one
  std::optional<ErrorHead> error = {};  ///< none: it does not know how wrong it is

  Flight flight = {};  ///< no runs: a model made by hand, or before training recorded them

  int nx() const { return static_cast<int>(states.size()); }
  int ny() const { return static_cast<int>(outputs.size()); }
  int nz() const { return static_cast<int>(initial_latent.size()); }
  int measured() const;  ///< outputs that step() takes; n_y less those that are computed
  int nu() const;        ///< known inputs, read or acting; 0 where step() takes none
  int nr() const {       ///< readings: outputs, then the inputs read, then stalenesses
    return ny() + static_cast<int>(inputs.size() + failures.outputs.size());
  }
};

/// A learned map of a model, by its name in the model file.
template <class NetworkType>
struct Named {
  std::string field;  ///< "drive.forward_map"
  NetworkType* network;
  Eigen::Index reads;  ///< the first of its inputs that matter: n_z of [z; y] where y has no weight
};

// What may be asked of a model whatever its structure.

/// "kkl", "driven_kkl", ...: its name in model files.
std::string_view structure_name(const Model& model);

/// All its learned maps, in the order of the model file.
std::vector<Named<const Network>> networks(const Model& model);
std::vector<Named<Network>> networks(Model& model);

/// The map from z (and y) to the estimate; null where z is the estimate.
const Network* inverse_map(const Model& model);
Network* inverse_map(Model& model);

/// D and F where the latent system is linear, else null.
const LinearLatent* linear_latent(const Model& model);
LinearLatent* linear_latent(Model& model);

/// Known inputs that step() takes.
const std::vector<Channel>& inputs(const Model& model);

/// The outputs that step() takes; those that are computed are behind them.
std::vector<Channel> measured_channels(const Model& model);

/// [y; u; staleness]: what F and T* read, and the range of each, n_r.
std::vector<Channel> readings(const Model& model);
Eigen::VectorXd reading_min(const Model& model);
Eigen::VectorXd reading_max(const Model& model);

/// The same observer without inputs that act on its estimate; those that it reads it needs.
Model without_inputs(Model model);

/// The domain is of z less S y for this reading: an angle, or one of relative_outputs.
bool is_relative(const Model& model, int reading);

/// T* saturates, and an output is relative.
bool saturates_relative(const Model& model);

}  // namespace nlo::codegen
