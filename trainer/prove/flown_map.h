// SPDX-License-Identifier: MIT
// Describes an exported inverse map T* by the largest error of each of its numbers and operations. It covers float
// (either policy, any order of the sums), 16-bit weights, and the integers of --scalar int16.
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

/// The unit roundoff u of float.
inline constexpr double kFloatUnit = 0x1p-24;
/// Returns gamma_n of float, rounded up.
double float_gamma(Eigen::Index roundings);

/// Layer l reads a and computes W a + b. The export has (W + known +- off) a + (b + known +- off), summed as below.
struct FlownLayer {
  codegen::DenseLayer known, off;
  double sum_rounding = 0.0;  ///< error of each sum, relative to the sum of its terms' sizes
  double sum_off = 0.0;       ///< absolute error of each sum, added to the relative one
  double largest = std::numeric_limits<double>::infinity();  ///< the export limits its activation to +- this
};

struct FlownMap {
  Eigen::VectorXd input_off;  ///< error of the first layer's inputs, n_in
  std::vector<FlownLayer> layers;
  double activation_off = 0.0;       ///< error of each activation
  double activation_relative = 0.0;  ///< additional error, relative to the size of its argument
  Eigen::MatrixXd path_off;          ///< error of the linear path, n_x x n_in
  double path_rounding = 0.0;        ///< error of adding the path, relative to the sizes of the sums
  double output_rounding = 0.0;      ///< error of each output, relative to its size
};

/// Returns the map of a float or 16-bit export. `folded` comes from in_formats().
FlownMap flown_in_float(const JacobianEnclosure& real, const codegen::FoldedNetwork& folded);

/// Returns the map of an int16 export for inputs between `low` and `high`, n_in. `largest`: the largest activation of
/// each hidden layer that quantise() was given.
FlownMap flown_in_int16(const JacobianEnclosure& real, const codegen::QuantisedNetwork& network,
                        const std::vector<double>& largest, const Eigen::VectorXd& low, const Eigen::VectorXd& high);

/// Bounds the difference between z of a float export and z of the real equations, n_z. It holds after a reset for any
/// measurements and any number of steps, as long as z stays between `low` and `high`. The model must have linear latent
/// dynamics and no angles.
Eigen::VectorXd float_latent_error(const codegen::Model& model, const Eigen::VectorXd& low,
                                   const Eigen::VectorXd& high);

}  // namespace nlo::trainer
