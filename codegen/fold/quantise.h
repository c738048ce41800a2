// SPDX-License-Identifier: MIT
// Quantises the inverse map to int16 for runtime/include/nlo/quantised_map.h, and gated units for quantised_units.h
// (`--scalar int16`). The scales follow from the ranges of the training and from the norms of the rows, so that no sum
// can overflow.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "codegen/model/folded.h"
#include "codegen/model/model.h"
#include "codegen/reference/quantised_network.h"

namespace nlo::codegen {

/// The box of T*'s inputs, [z; y] or z: the training domain of z, with S y added for angles, and the range of y.
/// Outside of the box an int16 map returns its value at the nearest point of the box.
struct InputBox {
  Eigen::VectorXd min, max;
};
InputBox input_box(const Model& model, const FoldedModel& folded);

/// Returns the inverse map, and gated units, in int16. Throws Error, with the layer and the remedy, for a structure
/// without int16, and if weights are too large for any scale.
QuantisedModel quantise(const Model& model, const FoldedModel& folded);

/// Quantises `network` for inputs in `box`. `largest`: largest activation of each hidden layer; only relu reads it.
QuantisedNetwork quantise(const FoldedNetwork& network, const InputBox& box, const std::vector<double>& largest);

/// Returns the largest activation of each hidden layer of `map`, which is `network` when folded, for inputs in `box`: 1
/// for tanh, for relu 1.1 times the largest in training. Without a record of the training it is 1.1 times the largest
/// over 4,096 inputs, half of them corners of the box. That exceeds training data and costs a bit or two of resolution.
std::vector<double> largest_activations(const Network& map, const FoldedNetwork& network, const InputBox& box);

}  // namespace nlo::codegen
