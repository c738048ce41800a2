// SPDX-License-Identifier: MIT
// An inverse map T* as it flies, told from the real one by how far each of its numbers and operations can be off: of
// float (either policy, any order of the sums), of 16-bit weights, and of the integers of --scalar int16.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "codegen/fold/fold.h"
#include "codegen/model/model.h"
#include "codegen/reference/quantised_network.h"
#include "trainer/prove/jacobian_enclosure.h"

namespace nlo::trainer {

/// u of float.
inline constexpr double kFloatUnit = 0x1p-24;
/// gamma_n of float, upwards.
double float_gamma(Eigen::Index roundings);

/// Layer l reads a and gives W a + b, of which it flies (W + known +- off) a + (b + known +- off), summed as below.
struct FlownLayer {
  codegen::DenseLayer known, off;
  double sum_rounding = 0.0;                                 ///< times the sum of the sizes of all terms
  double sum_off = 0.0;                                      ///< further error of each sum
  double largest = std::numeric_limits<double>::infinity();  ///< its activation saturates there
};

struct FlownMap {
  Eigen::VectorXd input_off;  ///< error of the first layer's inputs, n_in
  std::vector<FlownLayer> layers;
  double activation_off = 0.0;       ///< error of each activation
  double activation_relative = 0.0;  ///< times the size of its argument, besides
  Eigen::MatrixXd path_off;          ///< error of the linear path, n_x x n_in
  double path_rounding = 0.0;        ///< times the sizes of the sums it is added to
  double output_rounding = 0.0;      ///< times the size of an output
};

/// The map of a float or 16-bit export: `folded` as in_formats() gives it.
FlownMap flown_in_float(const JacobianEnclosure& real, const codegen::FoldedNetwork& folded);

/// The map of an int16 export, for inputs between `low` and `high`, n_in. `largest`: the largest activation of each
/// hidden layer, as quantise() was given it.
FlownMap flown_in_int16(const JacobianEnclosure& real, const codegen::QuantisedNetwork& network,
                        const std::vector<double>& largest, const Eigen::VectorXd& low, const Eigen::VectorXd& high);

/// How far z of a float export can be from z of the real equations, n_z: while z stays within `low`, `high` from a
/// reset on, for any measurements and any number of steps. For a model whose z moves linearly, without angles.
Eigen::VectorXd float_latent_error(const codegen::Model& model, const Eigen::VectorXd& low,
                                   const Eigen::VectorXd& high);

}  // namespace nlo::trainer
