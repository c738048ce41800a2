// SPDX-License-Identifier: MIT
// A trained KKL observer as a value: named, shaped fields with their provenance. What a model file holds, what an
// export reads. All numbers are double here; an export rounds each of them once, to the scalar of its target.
#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

namespace nlo::codegen {

/// One measured output or estimated state.
struct Channel {
  std::string name;   ///< an identifier
  std::string unit;   ///< "rad/s"; empty when dimensionless or unknown
  double wrap = 0.0;  ///< full turn of an angle in the channel's unit (2 pi for rad); 0: not an angle
};

/// One layer of the inverse map T*: a = W u + b. The last layer is linear, the others are followed by the activation.
struct DenseLayer {
  Eigen::MatrixXd weights;  ///< n_out x n_in
  Eigen::VectorXd bias;     ///< n_out
};

/// KKL observer (16), sampled at a fixed rate:
///   z_0     = initial_latent + [starts_steady] S y_0,        S = -D^-1 F  (steady state per unit of output)
///   z_{k+1} = A z_k + B0 y_k + B1 y_{k+1}                    (A, B0, B1) = discretisation of (D, F) by `hold`
///   u_k     = (features [z_k; y_k] - feature_mean) / feature_scale
///   x_hat_k = state_mean + state_scale * (mlp(u_k) + skip u_k)
/// D is block diagonal: first `pairs` 2x2 blocks [[re, -im], [im, re]], then real eigenvalues.
struct Model {
  std::string name;  ///< an identifier: namespace and file name of what is exported
  std::vector<Channel> outputs;
  std::vector<Channel> states;

  double sample_period_s = 0.0;
  std::string hold = "first_order";  ///< zero_order, first_order or rk4
  int pairs = 0;
  Eigen::VectorXd eigenvalues;       ///< n_z [1/s]: (re, im) of each pair, then the real ones
  Eigen::MatrixXd output_injection;  ///< F, n_z x n_y; a zero row is a clock: exp(lambda t) from its initial latent
  Eigen::VectorXd initial_latent;    ///< n_z
  bool starts_steady = false;        ///< warm start: the first output sets z to its steady state

  int stale_after = 10;                    ///< this many unusable measurements in a row make the estimate stale
  Eigen::VectorXd output_min, output_max;  ///< n_y: measurements outside are clamped (angles: refused)
  Eigen::VectorXd latent_min, latent_max;  ///< n_z: training domain of z, relative to S y for angle outputs

  Eigen::MatrixXd features;  ///< n_u x (n_z + n_y), over [z; y]
  Eigen::VectorXd feature_mean, feature_scale;
  std::string activation = "tanh";  ///< tanh, relu or silu
  std::vector<DenseLayer> layers;   ///< at least one; the last has n_x rows
  Eigen::MatrixXd skip;             ///< n_x x n_u linear path beside the network; 0 x 0 when there is none
  Eigen::VectorXd state_mean, state_scale;

  /// Facts for the reader and for reproduction, in the order they are shown: version, seed, config, data hash,
  /// errors...
  std::vector<std::pair<std::string, std::string>> provenance;

  int nx() const { return static_cast<int>(states.size()); }
  int ny() const { return static_cast<int>(outputs.size()); }
  int nz() const { return static_cast<int>(eigenvalues.size()); }
};

}  // namespace nlo::codegen
