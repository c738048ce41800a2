// SPDX-License-Identifier: MIT
// Bounds the size of an estimate for every reachable z. It uses branch and bound on affine enclosures of T*
// (jacobian_enclosure.h), over the box of all reachable z and all readings.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "codegen/model/model.h"
#include "trainer/prove/map_region.h"

namespace nlo::trainer {

/// Returns the box of all reachable z and of the readings' ranges. If the model saturates, z is limited as T* limits
/// it. Empty if no bound of z is known.
std::optional<MapRegion> reachable_region(const codegen::Model& model);

struct LargestOutput {
  double bound = 0.0;  ///< bound of |output|
  double found = 0.0;
  Eigen::VectorXd where;  ///< [z; y] of the largest found value
  std::int64_t boxes = 0;
};

/// Bounds |T*_i| over the region. Ends when the bound is within `gap` of the largest found value, or after `boxes`.
LargestOutput largest_output(const codegen::Model& model, const MapRegion& region, Eigen::Index output,
                             std::int64_t boxes, double gap, std::uint64_t seed);

}  // namespace nlo::trainer
