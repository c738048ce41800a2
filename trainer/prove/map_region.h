// SPDX-License-Identifier: MIT
// The arguments of a model's T*: boxes of [z; y], or of z - S y for readings that T* uses relative to their steady
// state S y.
#pragma once

#include <Eigen/Core>
#include <array>

#include "codegen/model/model.h"
#include "trainer/prove/jacobian_enclosure.h"

namespace nlo::trainer {

/// Returns the number of readings that T* gets beside z: n_r or 0.
Eigen::Index readings_of_map(const codegen::Model& model);

/// All [z; y] = inputs p with p in the box. Inputs that T* does not read have no width.
struct MapRegion {
  InputBox box;
  Eigen::MatrixXd inputs;  ///< (n_z + n_r) x (n_z + n_r)
};

/// Returns the region with these limits of p = [z; y], or with `relative` of [z - S y; y] as in in_domain().
MapRegion region_between(const codegen::Model& model, const Eigen::VectorXd& low, const Eigen::VectorXd& high,
                         bool relative);

/// Returns the domain of the training and the ranges of the readings.
MapRegion domain_region(const codegen::Model& model);

/// Returns the two halves of a box along an input, without a gap between them.
std::array<InputBox, 2> halves(const InputBox& box, Eigen::Index along);

}  // namespace nlo::trainer
