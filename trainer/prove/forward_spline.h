// SPDX-License-Identifier: MIT
// A spline T~ in place of the map T of Theorem 1, dT/dx f = D T + F h (5): how far it is from solving (5) can be
// bounded over a whole region of states, where T itself is known at points alone (forward_map.h). Whatever T~ is,
//   d(z - T~(x))/dt = D (z - T~(x)) + F v - dT~/dx w - r(x),   r = dT~/dx f - D T~ - F g
// so a bound of r is all that a proof needs. Between two samples the observer reads y by its hold; its effect on z
// is in g, to the third order of the sample period (HoldEffect).
//
// T~ is Hermite's: a polynomial over each cell of the region, of the degree 2 m - 1 in each state, that agrees with its
// neighbours in all derivatives below m in each state. On a region around a limit cycle it fits where one polynomial
// for all of the region would not.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "trainer/prove/hold_effect.h"
#include "trainer/prove/interval_matrix.h"
#include "trainer/prove/latent_system.h"
#include "trainer/prove/plant_enclosure.h"
#include "trainer/prove/state_region.h"

namespace nlo::trainer {

/// T~ over a box of states that lies in one cell.
struct MapRanges {
  IntervalMatrix at_centre;         ///< T~, n_z x 1
  IntervalMatrix slopes_at_centre;  ///< dT~/dx, n_z x n_x
  Eigen::VectorXd bent;             ///< |T~(x) - T~(c) - dT~/dx(c) (x - c)| of each row at most
  IntervalMatrix slopes;            ///< dT~/dx over the box
};

class ForwardSpline {
 public:
  static constexpr std::size_t kMostStates = 3;

  /// The T~ that leaves least of (5) over the region, in least squares over points of each cell, with
  /// g of the hold. Many maps solve (5) beside an orbit that draws others in: of these the one that is z at
  /// x, columns of `x` (n_x x N) in the region and `z` (n_z x N). Keeps references to `plant` and `region`.
  ForwardSpline(const PlantEnclosure& plant, LatentSystem system, const StateRegion& region, HoldEffect hold,
                const Eigen::MatrixXd& x, const Eigen::MatrixXd& z);

  MapRanges over(const StateBox& box) const;

  /// |r| of each row at most over the box, by the polynomials of all that it is made of.
  Eigen::VectorXd residual(const StateBox& box) const;

 private:
  using Powers = std::array<int, kMostStates>;  ///< powers of the states in a product

  /// The polynomial of the distance from the box's centre in units of `unit` (n_x), products x n_z; and how far each of
  /// its coefficients can be off.
  struct Local {
    Eigen::MatrixXd coefficients, errors;
  };
  Local local(const StateBox& box, const Eigen::VectorXd& unit) const;

  Eigen::MatrixXcd fitted(const LatentMode& mode, const Eigen::MatrixXd& x, const Eigen::MatrixXd& z) const;

  const PlantEnclosure& plant_;
  const StateRegion& region_;
  LatentSystem system_;
  Eigen::MatrixXd d_;  ///< D as a matrix
  HoldEffect hold_;
  int shared_;                  ///< m
  std::vector<Powers> powers_;  ///< powers of all products over a cell; the first state's goes fastest
  std::vector<std::vector<Eigen::Index>> unknowns_;  ///< for each cell: the unknowns of its corners
  Eigen::Index unknown_count_ = 0;
  std::vector<StateBox> cells_;
  std::vector<Eigen::MatrixXd> coefficients_;  ///< for each cell: products x n_z; distances in the cell's radius
  double error_ = 0.0;                         ///< rounding error of each coefficient
};

}  // namespace nlo::trainer
