// SPDX-License-Identifier: MIT
#include "trainer/prove/map_region.h"

#include <cmath>

#include "codegen/model/flown_ranges.h"
#include "codegen/model/latent_step.h"
#include "trainer/prove/rounding.h"

namespace nlo::trainer {

Eigen::Index readings_of_map(const codegen::Model& model) {
  return codegen::inverse_map(model)->inputs() - model.nz();
}

MapRegion region_between(const codegen::Model& model, const Eigen::VectorXd& low, const Eigen::VectorXd& high,
                         bool relative) {
  const Eigen::Index nz = model.nz(), nr = readings_of_map(model), n = nz + nr;
  const Eigen::VectorXd centre = 0.5 * (low + high), radius = (high - centre).cwiseMax(centre - low);
  MapRegion region{{centre, upward(radius, 1)}, Eigen::MatrixXd::Identity(n, n)};
  const bool reads = !codegen::inverse_map(model)->features.rightCols(nr).isZero(0.0);
  const Eigen::MatrixXd gain = codegen::steady_gain(model);
  for (int j = 0; j < nr; ++j) {
    if (relative && codegen::is_relative(model, j)) {  // z follows y, even if T* does not read y
      region.inputs.block(0, nz + j, nz, 1) = gain.col(j);
    } else if (!reads) {
      region.box.radius(nz + j) = 0.0;
    }
  }
  return region;
}

MapRegion domain_region(const codegen::Model& model) {
  const Eigen::Index nz = model.nz(), nr = readings_of_map(model);
  Eigen::VectorXd low(nz + nr), high(nz + nr);
  low << model.latent_min, codegen::flown_ranges(model).kept_min.head(nr);
  high << model.latent_max, codegen::flown_ranges(model).kept_max.head(nr);
  return region_between(model, low, high, true);
}

std::array<InputBox, 2> halves(const InputBox& box, Eigen::Index along) {
  std::array<InputBox, 2> both{box, box};
  for (std::size_t i = 0; i < both.size(); ++i) {
    double& radius = both[i].radius(along);
    radius *= 0.5;
    both[i].centre(along) += i == 0 ? -radius : radius;
    radius += 2.0 * kUnit * (radius + std::abs(both[i].centre(along)));
  }
  return both;
}

}  // namespace nlo::trainer
