// SPDX-License-Identifier: MIT
// Integrates a nonlinear latent system over whole trajectories by an explicit Runge-Kutta method, and computes its
// gradient in two ways:
//   backprop  exact for the discrete steps: each step's stages are run again from the stored z_k and pulled back
//   adjoint   Proposition 1, (13)-(14): p' = -p dF/dz integrated backwards by RK4, with dl/dz_k added at the samples;
//             mu' = -p dF/dtheta by the same weights. z between samples is the cubic Hermite interpolant of the stored
//             z_k (fourth order; integrating z itself backwards would undo the contraction that makes it an observer).
// Both store z at the samples and the activations of one step, so they need O(layers) memory beside the trajectory.
// Their difference decreases with the fourth power of the step.
#pragma once

#include <limits>

#include "nlo/explicit_rk.h"
#include "trainer/gradients/sensitivity/ode_dynamics.h"

namespace nlo::trainer {

/// A Runge-Kutta method of the runtime (kEuler, kHeun, kRk4: explicit_rk.h), so that training computes the same steps
/// as flight. It may have any number of stages. The tableau must outlive it; tableaux are constants.
///   z_i = z + h sum_j a_ij k_j,  k_i = F(z_i, y(t + c_i h)),  z+ = z + h sum_i b_i k_i,  j < i
class RungeKutta {
 public:
  template <int kStages>
  explicit(false) RungeKutta(const Tableau<double, kStages>& tableau)
      : stages_(kStages), a_(tableau.a[0]), b_(tableau.b), c_(tableau.c) {
    static_assert(kStages <= kMostStages);
  }
  template <int kStages>
  RungeKutta(const Tableau<double, kStages>&&) = delete;

  static constexpr int kMostStages = 4;
  int stages() const { return stages_; }
  double a(int i, int j) const { return a_[i * stages_ + j]; }
  double b(int i) const { return b_[i]; }
  double c(int i) const { return c_[i]; }

 private:
  int stages_;
  const double *a_, *b_, *c_;
};

/// Eight trajectories in the layout of a SegmentGroup: arrays are [row][time][8]. Readings are held or interpolated
/// between samples.
template <class Scalar>
struct OdeRun {
  int length = 0;                    ///< samples
  Hold hold = Hold::kFirstOrder;     ///< kRk4 is a ramp, too
  const Scalar* readings = nullptr;  ///< n_r x length x 8
  const Scalar* steps_s = nullptr;   ///< length x 8, step after each sample; or one number when `uniform`
  bool uniform = true;
  Scalar* latent = nullptr;                             ///< n_z x length x 8, written by integrate()
  const Scalar* cotangent = nullptr;                    ///< dl/dz, n_z x length x 8, read by the gradients
  int commands_from = std::numeric_limits<int>::max();  ///< see LatentShape
};

/// Fills run.latent from run.readings.
template <class Scalar>
void integrate(OdeDynamics<Scalar>& dynamics, const RungeKutta& method, const OdeRun<Scalar>& run);

/// Adds dl/dtheta to the gradient of the dynamics, exact for integrate() by the same method.
template <class Scalar>
void backprop(OdeDynamics<Scalar>& dynamics, const RungeKutta& method, const OdeRun<Scalar>& run);

/// Adds dl/dtheta to the gradient of the dynamics by the adjoint equation.
template <class Scalar>
void adjoint(OdeDynamics<Scalar>& dynamics, const OdeRun<Scalar>& run);

}  // namespace nlo::trainer
