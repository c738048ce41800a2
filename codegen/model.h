// SPDX-License-Identifier: MIT
// A trained observer as a value: named, shaped fields with their provenance. What a model file holds, what an export
// reads. All numbers are double here; an export rounds each of them once, to the scalar of its target.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "codegen/flight.h"

namespace nlo::codegen {

/// One measured output, estimated state or known input.
struct Channel {
  std::string name;   ///< an identifier
  std::string unit;   ///< "rad/s"; empty when dimensionless or unknown
  double wrap = 0.0;  ///< full turn of an angle in the channel's unit (2 pi for rad); 0: not an angle
};

/// One layer: a = W u + b.
struct DenseLayer {
  Eigen::MatrixXd weights;  ///< n_out x n_in
  Eigen::VectorXd bias;     ///< n_out
};

/// A learned map with its normalisation:
///   u   = (features in - feature_mean) / feature_scale
///   out = output_mean + output_scale * (mlp(u) + skip u)
struct Network {
  Eigen::MatrixXd features;  ///< n_u x n_in
  Eigen::VectorXd feature_mean, feature_scale;
  std::string activation = "tanh";  ///< tanh, relu or silu; after every layer but the last
  std::vector<DenseLayer> layers;   ///< at least one; the last has n_out rows
  Eigen::MatrixXd skip;             ///< n_out x n_u linear path beside the network; 0 x 0 when there is none
  Eigen::VectorXd output_mean, output_scale;
  std::vector<double> largest_activations = {};  ///< of each hidden layer, over the training data; empty: unknown

  int inputs() const { return static_cast<int>(features.cols()); }
  int outputs() const { return static_cast<int>(output_mean.size()); }
};

/// Luenberger-like observer (15) of a partially known plant, dx/dt = A x + g(x), y = C x:
///   x_hat' = A x_hat + g_hat(x_hat) + G (y - C x_hat)
struct LuenbergerDynamics {
  Eigen::MatrixXd state_matrix;   ///< A, n_x x n_x
  Eigen::MatrixXd output_matrix;  ///< C, n_y x n_x
  Eigen::MatrixXd gain;           ///< G, n_x x n_y; A - G C must be Hurwitz
  Network nonlinearity;           ///< g_hat, n_x -> n_x
};

/// What a driven KKL observer (24)-(25) adds for its known inputs u, dx/dt = f(x) + g(x) u:
///   phi(z) u = dT/dx(x_hat) g(x_hat) u,   x_hat = T*(z)
struct Drive {
  std::vector<Channel> inputs;
  std::string input_hold = "zero_order";  ///< zero_order: the u given has acted since the last sample (a command);
                                          ///< first_order: a ramp from the u of the last sample (measured with y)
  DenseLayer input_field;  ///< g: reshape(W x + b), n_x n_u rows, one column of g after the other. Affine in x: exact
                           ///< for constant and bilinear inputs
  Network forward_map;     ///< T, n_x -> n_z
};

/// An observer of sampled outputs y with a latent state z. What is set below tells which (structure()):
///
///   kkl         (16)       z' = D z + F y,               x_hat = T*(z)
///   driven_kkl  (24)-(25)  z' = D z + F y + phi(z) u,    x_hat = T*(z)
///   luenberger  (15)       z' = A z + g_hat(z) + G (y - C z),  x_hat = z
///   general     (11)       z' = F(z, y),                 x_hat = G(z)
///
/// T* and G of (11) are the inverse map and may read the latest y beside z. `hold` says how y runs between samples.
/// z starts at initial_latent; with starts_steady (KKL) at that plus S y_0, S = -D^-1 F the steady state per unit of y.
/// D is block diagonal: first `pairs` 2x2 blocks [[re, -im], [im, re]], then real eigenvalues.
struct Model {
  std::string name;  ///< an identifier: namespace and file name of what is exported
  std::vector<Channel> outputs;
  std::vector<Channel> states;

  double sample_period_s = 0.0;
  std::string hold = "first_order";  ///< zero_order, first_order or rk4 (a ramp; KKL: by one Runge-Kutta step)
  Eigen::VectorXd initial_latent;    ///< n_z
  bool starts_steady = false;        ///< warm start: the first output sets z to its steady state

  Eigen::VectorXd output_min, output_max;  ///< n_y: measurements outside are clamped (angles: refused)
  Eigen::VectorXd latent_min, latent_max;  ///< n_z: training domain of z, relative to S y for relative outputs
  std::vector<int> relative_outputs =
      {};  ///< KKL, rising: outputs beside the angles that T* knows only through z - S y,
           ///< so that where they are at rest is not of the domain; empty: angles alone

  // KKL observers, driven or not; empty for the others.
  int pairs = 0;
  Eigen::VectorXd eigenvalues;       ///< n_z [1/s]: (re, im) of each pair, then the real ones
  Eigen::MatrixXd output_injection;  ///< F, n_z x n_y; a zero row is a clock: exp(lambda t) from its initial latent

  Network inverse_map;  ///< [z; y] -> x_hat, n_z + n_y -> n_x; empty for a Luenberger observer

  // At most one of these is set.
  std::optional<LuenbergerDynamics> luenberger;
  std::optional<Network> dynamics;  ///< F of (11): [z; y] -> dz/dt, n_z + n_y -> n_z. Its linear path is what makes it
                                    ///< stable, and nothing proves that it does
  std::optional<Drive> drive;

  /// Facts for the reader and for reproduction, in the order they are shown: version, seed, config, data hash,
  /// errors...
  std::vector<std::pair<std::string, std::string>> provenance;

  Flight flight = {};  ///< no runs: a model made by hand, or before training recorded them

  int nx() const { return static_cast<int>(states.size()); }
  int ny() const { return static_cast<int>(outputs.size()); }
  int nz() const { return static_cast<int>(initial_latent.size()); }
  int nu() const { return drive ? static_cast<int>(drive->inputs.size()) : 0; }
};

/// The domain is of z less S y for this output: an angle, or one of relative_outputs.
inline bool is_relative(const Model& m, int output) {
  if (m.outputs[static_cast<std::size_t>(output)].wrap > 0.0) return true;
  return std::find(m.relative_outputs.begin(), m.relative_outputs.end(), output) != m.relative_outputs.end();
}

/// "kkl", "driven_kkl", "luenberger" or "general".
inline std::string_view structure(const Model& m) {
  return m.luenberger ? "luenberger" : m.dynamics ? "general" : m.drive ? "driven_kkl" : "kkl";
}

/// The latent system is D, F: a KKL observer, driven or not.
inline bool has_linear_latent(const Model& m) {
  return !m.luenberger && !m.dynamics;
}

}  // namespace nlo::codegen
