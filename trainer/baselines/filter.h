// SPDX-License-Identifier: MIT
// What the Kalman filters share: the plant they know, their noise, and one step of either.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>

namespace nlo::trainer {

/// dx/dt = f(x) or, where inputs are known, driven(x, u), y = h(x) or driven_output(x, u); each maps a batch of x, one
/// column per point, with one u (n_u) for all.
struct FilterPlant {
  using Map = std::function<Eigen::MatrixXd(const Eigen::MatrixXd& x)>;
  using DrivenMap = std::function<Eigen::MatrixXd(const Eigen::MatrixXd& x, const Eigen::VectorXd& u)>;

  Map f, h;
  DrivenMap driven = {};              ///< null: autonomous
  Eigen::VectorXd output_wraps = {};  ///< full turns of outputs that are angles, else 0, n_y; empty: none is
  DrivenMap driven_output = {};       ///< null: y = h(x)
  double longest_step_s =
      std::numeric_limits<double>::infinity();  ///< of RK4: a longer sample period is divided evenly
};

struct FilterConfig {
  Eigen::VectorXd initial_state;       ///< n_x
  Eigen::MatrixXd initial_covariance;  ///< P0, n_x x n_x
  double process_variance = 1e-6;      ///< Q = this times I, per step
  /// Diagonal of R, one for all outputs or n_y.
  Eigen::VectorXd output_variance = Eigen::VectorXd::Zero(1);
  /// n_x, standard deviation per sqrt(s) of the plant's own noise: its square times the step is added to Q; empty: none.
  Eigen::VectorXd process_noise = {};
  bool held_inputs = false;       ///< the u of a sample has acted since the sample before; else a ramp from there
  Eigen::VectorXd farthest = {};  ///< n_x, an estimate with |x_i| beyond it is lost; empty: 1e9, as simulations escape
  /// Of R: a noise-free output is no reason to trust a linearisation.
  double least_output_variance = 1e-4;
};

/// Phi(x): x at the end of a sample period of `h` seconds by RK4, n_x x B. `u0`, `u1`: the inputs at both ends of it;
/// empty when nothing excites the plant.
Eigen::MatrixXd advance(const FilterPlant& plant, const Eigen::MatrixXd& x, double h, const Eigen::VectorXd& u0,
                        const Eigen::VectorXd& u1);

/// y at x, n_y x B. `u`: as above.
Eigen::MatrixXd output_at(const FilterPlant& plant, const Eigen::MatrixXd& x, const Eigen::VectorXd& u);

/// Takes angles among the differences of outputs (n_y x B) the short way round.
void wrap_outputs(const FilterPlant& plant, Eigen::MatrixXd& difference);

/// Q of a step of `h` seconds, n_x x n_x, and R, n_y x n_y.
Eigen::MatrixXd process_covariance(const FilterConfig& config, double h);
Eigen::MatrixXd output_covariance(const FilterConfig& config, Eigen::Index ny);

/// Where x has left what a state can be, or P the numbers, the filter begins anew from the configured x and P0: an outlier
/// can put the linearisation where the plant runs away within a step.
void restart_if_lost(const FilterConfig& config, Eigen::VectorXd& x, Eigen::MatrixXd& p);

/// The inputs at both ends of the period that ends with sample k: columns of `inputs` (n_u x N; 0 x 0: none).
struct HeldInputs {
  Eigen::VectorXd from, to;
};
HeldInputs inputs_of_step(const FilterConfig& config, const Eigen::MatrixXd& inputs, Eigen::Index k);

}  // namespace nlo::trainer
