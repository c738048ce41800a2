// SPDX-License-Identifier: MIT
// A spline T~ that approximates the map T of Theorem 1, dT/dx f = D T + F h (5). Its residual in (5) can be bounded
// over a whole region of states, while T itself is only known at points (forward_map.h). For every T~,
//   d(z - T~(x))/dt = D (z - T~(x)) + F v - dT~/dx w - r(x),   r = dT~/dx f - D T~ - F g
// so a bound of r is all that a proof needs. Between two samples the observer holds y. The output g includes the effect
// of this hold on z, up to the third order of the sample period (HoldEffect).
//
// T~ is a Hermite spline: over each cell of the region it is a polynomial of degree 2 m - 1 in each state, and it
// agrees with its neighbours in all derivatives of order below m in each state. It can therefore fit a region around a
// limit cycle, where a single polynomial could not.
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
  Eigen::VectorXd bent;             ///< bound of |T~(x) - T~(c) - dT~/dx(c) (x - c)| for each row
  IntervalMatrix slopes;            ///< dT~/dx over the box
};

class ForwardSpline {
 public:
  static constexpr std::size_t kMostStates = 3;

  /// Fits T~ by least squares: it minimises the residual of (5), with the g of `hold`, over points of each cell. Near
  /// an attracting orbit many maps solve (5). Among them the fit selects the map with T~(x) = z for the columns of `x`
  /// (n_x x N) in the region and of `z` (n_z x N). Keeps references to `plant` and `region`.
  ForwardSpline(const PlantEnclosure& plant, LatentSystem system, const StateRegion& region, HoldEffect hold,
                const Eigen::MatrixXd& x, const Eigen::MatrixXd& z);

  MapRanges over(const StateBox& box) const;

  /// Returns a bound of |r| over the box for each row, from the polynomials of all its terms.
  Eigen::VectorXd residual(const StateBox& box) const;

 private:
  using Powers = std::array<int, kMostStates>;  ///< powers of the states in a product

  /// T~ as a polynomial of the distance from the box's centre, in units of `unit` (n_x): its coefficients (products x
  /// n_z) and bounds of their errors.
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
  int shared_;                                       ///< m
  std::vector<Powers> powers_;                       ///< powers of all products; the first state's changes fastest
  std::vector<std::vector<Eigen::Index>> unknowns_;  ///< for each cell: the unknowns of its corners
  Eigen::Index unknown_count_ = 0;
  std::vector<StateBox> cells_;
  /// For each cell: products x n_z, for distances in units of the cell's radius.
  std::vector<Eigen::MatrixXd> coefficients_;
  double error_ = 0.0;  ///< rounding error of each coefficient
};

}  // namespace nlo::trainer
