// SPDX-License-Identifier: MIT
// Steps of the reference by the Runge-Kutta method, in pieces of about one sample period as in the runtime
// (nlo/explicit_rk.h).
#pragma once

#include <nlo/explicit_rk.h>
#include <nlo/latent.h>
#include <Eigen/Core>

#include "codegen/reference/dynamics.h"
#include "codegen/reference/rk4.h"

namespace nlo::codegen {

/// Returns a signal between two samples.
template <class Vector, class Scalar>
Vector held(Hold hold, const Vector& from, const Vector& to, Scalar part) {
  if (hold == Hold::kZeroOrder) return from;
  return (Scalar(1) - part) * from + part * to;
}

/// Advances z by one step of dt_s with dynamics.slope().
template <class Scalar>
void integrate(const ReferenceDynamics<Scalar>& dynamics, Hold hold, double sample_period_s,
               Eigen::Matrix<Scalar, Eigen::Dynamic, 1>& z, const Between<Scalar>& over, double dt_s) {
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  const int pieces = pieces_of(dt_s, sample_period_s);
  const auto h = static_cast<Scalar>(dt_s / pieces);
  for (int i = 0; i < pieces; ++i)
    z = rk4_step(z, h, [&](Scalar c, const Vector& at) -> Vector {
      const auto part = static_cast<Scalar>((i + static_cast<double>(c)) / pieces);
      return dynamics.slope(at, held(hold, over.y, over.y_next, part), over.u_next);
    });
}

}  // namespace nlo::codegen
