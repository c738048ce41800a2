// SPDX-License-Identifier: MIT
// The motion of a latent state between two samples: the equations of a structure, with dynamic sizes and without
// folding. ReferenceObserver steps them; each structure's module has its own.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "codegen/reference/reference_network.h"

namespace nlo::codegen {

/// Readings that act on the latent state between two samples.
template <class Scalar>
struct Between {
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  const Vector &y, &y_next;  ///< readings, n_r, with their inputs as in ReferenceObserver
  const Vector &u, &u_next;  ///< n_u, inputs that act apart from the readings; may be empty
  /// For each output: true if it was measured at y_next. The others are held or decay. Null: all were measured.
  const std::vector<bool>* arrived = nullptr;
};

template <class Scalar>
class ReferenceDynamics {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  virtual ~ReferenceDynamics() = default;

  /// Starts z (n_z x B), which holds the initial latent, at the first sample with the readings y (n_r x B).
  ///   arrived  for each output: true if it was measured; null: all were measured
  virtual void start(Matrix& z, const Matrix& y, const std::vector<bool>* arrived) const {
    (void)z;
    (void)y;
    (void)arrived;
  }

  /// Advances z (n_z) by a step of `dt_s`, in place.
  virtual void advance(Vector& z, const Between<Scalar>& over, double dt_s) = 0;

  /// Returns the longest step [s]; longer ones are refused.
  virtual double longest_step_s() const { return std::numeric_limits<double>::infinity(); }

  /// Turns the output of T*, n_x x B, into the estimate, in place.
  virtual void finish(Matrix& x_hat) const { (void)x_hat; }

  /// Returns dz/dt, n_z x B, at z (n_z x B) and y (n_y x B). u (n_u) is the same for all columns; empty: no inputs.
  virtual Matrix slope(const Matrix& z, const Matrix& y, const Vector& u) const = 0;
};

/// Returns [z; y], column by column.
template <class Scalar>
Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic> stacked(
    const Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>& z,
    const Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>& y) {
  Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic> both(z.rows() + y.rows(), z.cols());
  both << z, y;
  return both;
}

}  // namespace nlo::codegen
