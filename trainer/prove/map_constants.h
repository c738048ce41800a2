// SPDX-License-Identifier: MIT
// The constants of a map T in Proposition 2: L_T, L_Tx, and T at the points where the bound is applied. They are exact
// on a linear plant. Elsewhere they are the largest values at samples of the plant's runs, and the true constants may
// be larger.
#pragma once

#include <Eigen/Core>

#include "trainer/data/dataset.h"
#include "trainer/plants/linear.h"
#include "trainer/plants/plant.h"
#include "trainer/prove/latent_system.h"

namespace nlo::trainer {

struct MapConstants {
  bool exact = false;
  Eigen::MatrixXd matrix;      ///< T of a linear plant, n_z x n_x; empty otherwise
  double l_t = 0.0;            ///< |x1 - x2| <= L_T |T(x1) - T(x2)|
  double l_tx = 0.0;           ///< |dT/dx| <= L_Tx; infinite if T is continuous but not differentiable
  Eigen::VectorXd row_slopes;  ///< largest |rows of dT/dx| for each mode, see widen_row_slopes()
  Eigen::MatrixXd start;       ///< T(x(0)), n_z x runs
  Eigen::MatrixXd x, z;        ///< states spread over the runs, and T of them; empty on a linear plant
  double pde_residual = 0.0;  ///< largest |dT/dx f - D T - F h| relative to the size of its terms, at the starts of the
                              ///< runs
};

/// Computes T from the Sylvester equation: L_T = 1 / smallest singular value, L_Tx = the largest. Throws codegen::Error
/// if T does not exist or is not injective.
MapConstants exact_map_constants(const LinearPlant& plant, const LatentSystem& system, const Eigen::MatrixXd& initial);

/// Computes T by forward_map.h along `runs`, undisturbed runs of `plant` that start at `initial` (n_x x runs). L_T is
/// the largest of |x1 - x2| / |T(x1) - T(x2)| over pairs of states, and of 1 / smallest singular value of dT/dx. If a
/// ten times finer difference gives a slope more than 1.5 times as large, L_Tx is infinite: then D is slower than the
/// plant contracts, and dT/dx has no limit.
MapConstants sampled_map_constants(const Plant& plant, const LatentSystem& system, const Dataset& runs,
                                   const Eigen::MatrixXd& initial);

}  // namespace nlo::trainer
