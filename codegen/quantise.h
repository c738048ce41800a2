// SPDX-License-Identifier: MIT
// The inverse map in int16, as runtime/include/nlo/quantised_map.h executes it: what `--scalar int16` exports. Scales
// come from the ranges that training has seen and from the norms of the rows, so that no sum can overflow.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "codegen/fold.h"
#include "codegen/model.h"

namespace nlo::codegen {

/// One layer: sum = bias + weights q, q in Q15, and |bias| + sum |weights| 32767 < 2^31 in every row.
struct QuantisedLayer {
  Eigen::Matrix<std::int16_t, Eigen::Dynamic, Eigen::Dynamic> weights;  ///< n_out x n_in
  Eigen::Matrix<std::int32_t, Eigen::Dynamic, 1> bias;                  ///< n_out
  int shift = 1;  ///< 1 to 31; sum / 2^shift is tanh's argument in Q16, or relu's result in Q15. Not read in the last
};

/// out = scale (integer layers)(saturate((in - centre) gain)) + linear_path in
struct QuantisedNetwork {
  Activation activation;         ///< kTanh (by table) or kRelu; after every layer but the last
  Eigen::VectorXf centre, gain;  ///< n_in; gain is 32767 / half of the input's range
  std::vector<QuantisedLayer> layers;
  Eigen::VectorXf scale;        ///< n_out; result per unit of the last sums
  Eigen::MatrixXf linear_path;  ///< n_out x n_in; 0 x 0: none

  Eigen::Index inputs() const { return centre.size(); }
  Eigen::Index outputs() const { return scale.size(); }
};

/// The box of what T* reads, [z; y] or z: the training domain of z, with S y added for angles, and the range of y.
/// Outside of it an int16 map answers as at the nearest point of it.
struct InputBox {
  Eigen::VectorXd min, max;
};
InputBox input_box(const Model& model, const FoldedModel& folded);

/// The inverse map of a KKL observer in int16. Throws Error, naming the layer and the mend, for another structure, for
/// silu, and when weights are too large for any scale.
QuantisedNetwork quantise(const Model& model, const FoldedModel& folded);

/// `network` over inputs in `box`. `largest` has the largest activation of each hidden layer; only relu reads it.
QuantisedNetwork quantise(const FoldedNetwork& network, const InputBox& box, const std::vector<double>& largest);

/// Largest activation of each hidden layer of `map`, which is `network` when folded, for inputs in `box`: 1 for tanh;
/// for relu 1.1 times what training recorded. Without a record: 1.1 times the largest over 4,096 inputs, half of them
/// corners of the box, which is more than training data reach and costs a bit or two of resolution.
std::vector<double> largest_activations(const Network& map, const FoldedNetwork& network, const InputBox& box);

/// Rows of a layer as the kernel executes them: those of zeros that fill up its blocks of 4 and 5 included.
Eigen::Index padded_rows(Eigen::Index rows);

/// Bytes of the nlo::QuantisedMap that holds it, padding included.
Eigen::Index packed_bytes(const QuantisedNetwork& network);

/// The very bits that nlo::QuantisedMap::evaluate gives, on any target.
Eigen::VectorXf evaluate(const QuantisedNetwork& network, const Eigen::VectorXf& in);

}  // namespace nlo::codegen
