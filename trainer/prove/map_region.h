// SPDX-License-Identifier: MIT
// The arguments of a model's T*: boxes of [z; y], or of z - S y for readings that T* uses relative to their steady
// state S y.
#pragma once

#include <Eigen/Core>
#include <array>

#include "codegen/model/model.h"
#include "trainer/prove/jacobian_enclosure.h"

namespace nlo::trainer {

/// How many readings T* is given beside z: n_r, or none.
Eigen::Index readings_of_map(const codegen::Model& model);

/// All [z; y] = inputs p with p in the box. What T* does not read has no width.
struct MapRegion {
  InputBox box;
  Eigen::MatrixXd inputs;  ///< n_z + n_r square
};

/// The region with these ends of p = [z; y], or of [z - S y; y] as in_domain() has it: `relative`.
MapRegion region_between(const codegen::Model& model, const Eigen::VectorXd& low, const Eigen::VectorXd& high,
                         bool relative);

/// The domain that training has filled, and the readings' ranges.
MapRegion domain_region(const codegen::Model& model);

/// The two halves of a box along an input, without a gap between them.
std::array<InputBox, 2> halves(const InputBox& box, Eigen::Index along);

}  // namespace nlo::trainer
