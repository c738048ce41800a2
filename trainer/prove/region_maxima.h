// SPDX-License-Identifier: MIT
// The largest values of a plant and its map T~ that a proof over a region of states uses.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "trainer/prove/forward_spline.h"
#include "trainer/prove/plant_enclosure.h"

namespace nlo::trainer {

/// The largest values over the region of the quantities of the plant and of T~.
struct RegionMaxima {
  Eigen::VectorXd residual;                                          ///< n_z
  Eigen::VectorXd map;                                               ///< |T~|, n_z
  Eigen::MatrixXd map_slopes;                                        ///< |dT~/dx|, n_z x n_x
  std::array<Eigen::VectorXd, PlantRanges::kRates> rates;            ///< |L_f^i y|, n_y
  std::array<Eigen::MatrixXd, PlantRanges::kRates - 1> rate_slopes;  ///< n_y x n_x

  RegionMaxima(Eigen::Index nx, Eigen::Index ny, Eigen::Index nz)
      : residual(Eigen::VectorXd::Zero(nz)), map(residual), map_slopes(Eigen::MatrixXd::Zero(nz, nx)) {
    rates.fill(Eigen::VectorXd::Zero(ny));
    rate_slopes.fill(Eigen::MatrixXd::Zero(ny, nx));
  }

  void take(const PlantRanges& plant, const MapRanges& ranges) {
    map = map.cwiseMax(Eigen::VectorXd(ranges.at_centre.largest() + ranges.bent)).eval();
    map_slopes = map_slopes.cwiseMax(ranges.slopes.largest()).eval();
    for (std::size_t i = 0; i < rates.size(); ++i) rates[i] = rates[i].cwiseMax(plant.rates[i].largest()).eval();
    for (std::size_t i = 0; i < rate_slopes.size(); ++i)
      rate_slopes[i] = rate_slopes[i].cwiseMax(plant.rate_slopes[i].largest()).eval();
  }
};

}  // namespace nlo::trainer
