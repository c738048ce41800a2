// SPDX-License-Identifier: MIT
// The inverse map in int16, as runtime/include/nlo/quantised_map.h executes it, and gated units, as quantised_units.h
// does, for `--scalar int16`. Scales come from the ranges that training has seen and from the norms of the
// rows, so that no sum can overflow.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "codegen/model/folded.h"
#include "codegen/model/model.h"
#include "codegen/reference/quantised_network.h"

namespace nlo::codegen {

/// The box of T*'s inputs, [z; y] or z: the training domain of z, with S y added for angles, and the range of y.
/// Outside of it an int16 map answers as at the nearest point of it.
struct InputBox {
  Eigen::VectorXd min, max;
};
InputBox input_box(const Model& model, const FoldedModel& folded);

/// The inverse map, and gated units, in int16. Throws Error, naming the layer and the remedy, for a structure without,
/// for silu, and when weights are too large for any scale.
QuantisedModel quantise(const Model& model, const FoldedModel& folded);

/// `network` over inputs in `box`. `largest` has the largest activation of each hidden layer; only relu reads it.
QuantisedNetwork quantise(const FoldedNetwork& network, const InputBox& box, const std::vector<double>& largest);

/// Largest activation of each hidden layer of `map`, which is `network` when folded, for inputs in `box`: 1 for tanh;
/// for relu 1.1 times the largest in training. Without a record: 1.1 times the largest over 4,096 inputs, half of them
/// corners of the box, which is more than training data reach and costs a bit or two of resolution.
std::vector<double> largest_activations(const Network& map, const FoldedNetwork& network, const InputBox& box);

}  // namespace nlo::codegen
