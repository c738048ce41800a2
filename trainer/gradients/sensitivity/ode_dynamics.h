// SPDX-License-Identifier: MIT
// The right-hand side of a latent system in general: z' = F(z, y; theta), and its pullback. Eight trajectories are
// computed side by side; arrays are [row][8].
//
// Each structure makes its own dynamics (structures/trainable_structure.h). Tests check the sensitivities of every
// structure by finite differences, orders of convergence and parity.
#pragma once

#include <algorithm>

#include "trainer/gradients/sensitivity/linear_latent.h"

namespace nlo::trainer {

template <class Scalar>
class OdeDynamics {
 public:
  /// Points of a Runge-Kutta step whose derivative can be pulled back at the same time.
  static constexpr int kSlots = 4;

  OdeDynamics(int rows, int readings, int parameters) : rows_(rows), readings_(readings), parameters_(parameters) {}
  virtual ~OdeDynamics() = default;
  OdeDynamics(const OdeDynamics&) = delete;
  OdeDynamics& operator=(const OdeDynamics&) = delete;

  int rows() const { return rows_; }              ///< n_z
  int readings() const { return readings_; }      ///< n_r
  int parameters() const { return parameters_; }  ///< size of theta

  /// Reads theta. Call it first, and whenever theta has changed.
  virtual void prepare(const Scalar* theta) = 0;

  /// Writes z(0), n_z x 8.
  virtual void start(Scalar* z) const { std::fill(z, z + rows_ * kGroup, Scalar(0)); }

  /// Computes dz = F(z, y). Stores values for pull_back() in `slot`.
  virtual void derivative(int slot, const Scalar* z, const Scalar* y, Scalar* dz) = 0;

  /// Computes cotangent_z = (dF/dz)^T cotangent, and adds (dF/dtheta)^T cotangent, summed over the lanes, to the
  /// gradient. A slot may be pulled back more than once.
  virtual void pull_back(int slot, const Scalar* cotangent, Scalar* cotangent_z) = 0;

  virtual void clear_gradient() = 0;
  virtual void gradient(Scalar* out) const = 0;

 private:
  int rows_, readings_, parameters_;
};

}  // namespace nlo::trainer
