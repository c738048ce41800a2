// SPDX-License-Identifier: MIT
// Parts of models: channels, layers, and learned maps with their normalisation.
#pragma once

#include <nlo/kernels/activation.h>
#include <Eigen/Core>
#include <string>
#include <vector>

namespace nlo::codegen {

/// Shortest period of a slow output [sample periods]; below it a late sample is jitter.
inline constexpr double kShortestOutputPeriod = 1.5;

/// One measured output, estimated state or known input.
struct Channel {
  std::string name;             ///< an identifier
  std::string unit;             ///< "rad/s"; empty when dimensionless or unknown
  double wrap = 0.0;            ///< full turn of an angle in the channel's unit (2 pi for rad); 0: not an angle
  std::string expression = {};  ///< formula of a computed output (expression.h); empty: measured
  double period_s = 0.0;        ///< period of an output that is slower than the observer; 0: measured in every sample
};

/// One layer: a = W u + b.
struct DenseLayer {
  Eigen::MatrixXd weights;  ///< n_out x n_in
  Eigen::VectorXd bias;     ///< n_out
};

/// Linear rows that some outputs fall back to where the network is far from them:
///   row = offset + rows u
///   out = row + (out - row) / (1 + ((out - row) / reach)^2)
/// Near the row, the network decides. At the distance `reach`, half of the distance remains. Far away, the row decides.
/// So out is never further than reach / 2 from its row.
struct Fallback {
  std::vector<int> outputs;       ///< n_f outputs that fall back, in rising order; empty: none
  Eigen::MatrixXd rows;           ///< n_f x n_u
  Eigen::VectorXd offset, reach;  ///< n_f, in the units of the outputs; reach > 0
};

/// A learned map with its normalisation:
///   u   = (features in - feature_mean) / feature_scale, times its clock where a feature has one
///   out = output_mean + output_scale * (mlp(u) + skip u), then its fallback
struct Network {
  Eigen::MatrixXd features;  ///< n_u x n_in
  Eigen::VectorXd feature_mean, feature_scale;
  std::vector<int> feature_clocks = {};       ///< for each feature the row of z that multiplies it, or -1; empty: none
  Activation activation = Activation::kTanh;  ///< after every layer but the last; an activation that can be trained
  std::vector<DenseLayer> layers;             ///< at least one; the last has n_out rows
  Eigen::MatrixXd skip;                       ///< n_out x n_u linear path beside the network; 0 x 0: none
  Eigen::VectorXd output_mean, output_scale;
  std::vector<double> largest_activations = {};  ///< one for each hidden layer, over the training data; empty: unknown
  Fallback fallback = {};                        ///< only inverse_map may have one

  int inputs() const { return static_cast<int>(features.cols()); }
  int outputs() const { return static_cast<int>(output_mean.size()); }
};

/// Returns the row of z that multiplies feature f, or -1.
inline int clock_of(const Network& network, Eigen::Index f) {
  return network.feature_clocks.empty() ? -1 : network.feature_clocks[static_cast<std::size_t>(f)];
}

/// Multiplies each row of u (n_u x B), which is linear in the features, by its clock: a row of z (n_z or more x B).
template <class Features, class Latent>
void multiply_by_clocks(Features& u, const Latent& z, const std::vector<int>& feature_clocks) {
  for (std::size_t f = 0; f < feature_clocks.size(); ++f)
    if (feature_clocks[f] >= 0) u.row(static_cast<Eigen::Index>(f)).array() *= z.row(feature_clocks[f]).array();
}

}  // namespace nlo::codegen
