// SPDX-License-Identifier: MIT
// How large an estimate can get, for all reachable z: branch and bound on affine enclosures of T*
// (jacobian_enclosure.h), over the box of all z that readings can lead to and all readings.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "codegen/model/model.h"
#include "trainer/prove/map_region.h"

namespace nlo::trainer {

/// Wherever z can go, and the readings' ranges; as far as T* follows z of a model that saturates. Nothing where no
/// bound of z is known.
std::optional<MapRegion> reachable_region(const codegen::Model& model);

struct LargestOutput {
  double bound = 0.0;  ///< |output| at most
  double found = 0.0;
  Eigen::VectorXd where;  ///< [z; y] of that
  std::int64_t boxes = 0;
};

/// |T*_i| over the region. Ends within `gap` of the largest found value, or after `boxes`.
LargestOutput largest_output(const codegen::Model& model, const MapRegion& region, Eigen::Index output,
                             std::int64_t boxes, double gap, std::uint64_t seed);

}  // namespace nlo::trainer
