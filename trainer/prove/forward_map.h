// SPDX-License-Identifier: MIT
// Computes the map T of Theorem 1 from the plant itself, without learning: dT/dx f = D T + F h (5), solved by
//   T(x) = integral over s >= 0 of exp(D s) F h(X(x, -s)) ds
// where X(x, -s) is the plant run backwards. On a linear plant T is a matrix and solves a Sylvester equation.
//
// Backwards, a plant may escape in finite time (Van der Pol outside its limit cycle). As in the existence proofs the
// method builds on (Andrieu and Praly 2006, section 3.2), f is therefore switched off smoothly outside an open box O
// around the states of interest: X stays bounded, T exists everywhere, and (5) still holds for the true f inside O.
// T is one solution of (5) among several. On runs that stay in O, z converges to every solution.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "trainer/plants/plant.h"
#include "trainer/prove/latent_system.h"

namespace nlo::trainer {

/// The region in which the plant has its own f. O is centre +- `inner` half widths; beyond `outer` half widths f is 0.
struct MapDomain {
  Eigen::VectorXd centre, half_width;  ///< n_x
  double inner = 1.5, outer = 3.0;
};

/// Returns the box around the columns of `states` (n_x x N). Widths of zero are widened.
MapDomain domain_around(const Eigen::MatrixXd& states);

/// Numerical settings; the defaults leave relative errors of about 1e-7 in T.
struct ForwardMapOptions {
  double longest_step_s = 0.02;   ///< longest step of Runge-Kutta and of the quadrature [s]
  double step_per_time = 0.25;    ///< the step is at most this / max |lambda|
  double truncation = 1e-7;       ///< the past is followed until exp(max Re lambda s) falls below this
  double difference_step = 1e-4;  ///< step of the differences for dT/dx, in half widths of the domain
};

class ForwardMap {
 public:
  /// Keeps a reference to `plant`. The method has order 4 in the step: RK4 with half steps, and on each step exp(D s)
  /// times the parabola through three outputs is integrated exactly. Before the truncated past, the plant is assumed to
  /// stand still.
  ForwardMap(const Plant& plant, LatentSystem system, MapDomain domain, ForwardMapOptions options = {});
  ~ForwardMap();
  ForwardMap(const ForwardMap&) = delete;
  ForwardMap& operator=(const ForwardMap&) = delete;

  /// Returns T(x), n_z x B for n_x x B. Clocks have T = 0.
  Eigen::MatrixXd at(const Eigen::MatrixXd& x) const;

  /// dT/dx at each column of x (n_x x B), n_z x n_x: central differences, with an error of second order in the step.
  /// `step` is in half widths of the domain; 0: uses the option difference_step.
  std::vector<Eigen::MatrixXd> jacobians(const Eigen::MatrixXd& x, double step = 0.0) const;

  struct Path {
    std::vector<Eigen::MatrixXd> x, z;  ///< per sample: n_x x B and n_z x B
  };

  /// Returns T along whole runs of the plant: T(x(0)) is computed backwards, then z' = D z + F h(x) is integrated
  /// forwards with the plant, and T follows it. Forwards, errors of T decay as exp(D t). This avoids backward runs near
  /// an attractor, which would leave it.
  Path along(const Eigen::MatrixXd& initial, double sample_period_s, Eigen::Index samples) const;

  /// Returns |dT/dx f - D T - F h| at each column of x with the plant's own f, which is the residual of (5) [units of z
  /// per s].
  Eigen::VectorXd pde_residual(const Eigen::MatrixXd& x) const;

  const LatentSystem& system() const { return system_; }

 private:
  class Switched;
  double step_s() const;

  const Plant& plant_;
  std::unique_ptr<Switched> switched_;
  LatentSystem system_;
  std::vector<LatentMode> modes_;
  MapDomain domain_;
  ForwardMapOptions options_;
};

/// Returns T of dx/dt = A x, y = C x, which solves T A = D T + F C, n_z x n_x, mode by mode: t_i = f_i C (A -
/// lambda_i)^-1. Throws codegen::Error if D and A share an eigenvalue, because then there is no T.
Eigen::MatrixXd sylvester_map(const Eigen::MatrixXd& a, const Eigen::MatrixXd& c, const LatentSystem& system);

}  // namespace nlo::trainer
