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

/// A learned map with its normalisation:
///   u   = (features in - feature_mean) / feature_scale
///   out = output_mean + output_scale * (mlp(u) + skip u)
struct Network {
  Eigen::MatrixXd features;  ///< n_u x n_in
  Eigen::VectorXd feature_mean, feature_scale;
  Activation activation = Activation::kTanh;  ///< after every layer but the last; one that can be trained
  std::vector<DenseLayer> layers;             ///< at least one; the last has n_out rows
  Eigen::MatrixXd skip;                       ///< n_out x n_u linear path beside the network; 0 x 0 when there is none
  Eigen::VectorXd output_mean, output_scale;
  std::vector<double> largest_activations = {};  ///< one for each hidden layer, over the training data; empty: unknown

  int inputs() const { return static_cast<int>(features.cols()); }
  int outputs() const { return static_cast<int>(output_mean.size()); }
};

}  // namespace nlo::codegen
