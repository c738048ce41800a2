// SPDX-License-Identifier: MIT
// The latent system of a KKL observer, z' = D z + F y (3), split into modes, for the analysis of its robustness. A
// complex pair is one complex number z_r + i z_(r+1) that decays with one complex eigenvalue, so every mode is scalar.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "codegen/model/model.h"

namespace nlo::trainer {

/// D and F in the order of a model: first `pairs` 2x2 blocks [[re, -im], [im, re]], then real eigenvalues.
struct LatentSystem {
  Eigen::VectorXd eigenvalues;  ///< n_z [1/s]
  int pairs = 0;
  Eigen::MatrixXd injection;  ///< F, n_z x n_y; a row of zeros belongs to a clock

  Eigen::Index nz() const { return eigenvalues.size(); }
};

/// One mode: z_i' = lambda z_i + f y.
struct LatentMode {
  std::complex<double> lambda;  ///< [1/s]
  Eigen::RowVectorXcd f;        ///< n_y
  Eigen::Index row = 0;         ///< first row of this mode in z
  Eigen::Index rows = 1;        ///< number of rows in z; 2: a complex pair
  bool driven = true;           ///< false: a clock, which reads no output
};

LatentSystem latent_system(const codegen::Model& model);

std::vector<LatentMode> modes_of(const LatentSystem& system);

/// Returns max Re lambda [1/s]. Over all modes it gives the speed of the transient; with `driven_only`, over the modes
/// that read an output, it gives the gain of the noise. D is normal (its 2x2 blocks, too), so |exp(D t)| = exp(t max Re
/// lambda) without a factor.
double slowest(const LatentSystem& system, bool driven_only = false);

/// Returns max |lambda| [1/s].
double fastest(const LatentSystem& system);

/// Converts one complex row per mode into n_z real rows.
Eigen::MatrixXd real_rows(const std::vector<LatentMode>& modes, const Eigen::MatrixXcd& rows);

/// Returns D z for each column of z.
Eigen::MatrixXd apply_d(const LatentSystem& system, const Eigen::MatrixXd& z);

}  // namespace nlo::trainer
