// SPDX-License-Identifier: MIT
#include "trainer/baselines/ekf.h"

#include <cmath>
#include <limits>
#include <utility>

#include "codegen/base/linear_algebra.h"
#include "trainer/data/measurement_noise.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// x, then x + step e_i and x - step e_i of each state i: one batch gives a value and its Jacobian.
struct Stencil {
  explicit Stencil(const VectorXd& x)
      : step(cbrt_epsilon() * x.cwiseAbs().cwiseMax(1.0)), points(x.rowwise().replicate(2 * x.size() + 1)) {
    for (Index i = 0; i < x.size(); ++i) {
      points(i, 1 + 2 * i) += step[i];
      points(i, 2 + 2 * i) -= step[i];
    }
  }

  /// The Jacobian at x from the values of a function at the points.
  MatrixXd jacobian(const MatrixXd& values) const {
    MatrixXd result(values.rows(), step.size());
    for (Index i = 0; i < step.size(); ++i)
      result.col(i) = (values.col(1 + 2 * i) - values.col(2 + 2 * i)) / (2.0 * step[i]);
    return result;
  }

  /// Balances truncation (step^2) against rounding (epsilon / step).
  static double cbrt_epsilon() { return std::cbrt(std::numeric_limits<double>::epsilon()); }

  VectorXd step;
  MatrixXd points;
};

/// x_hat; with `deviations`, sqrt(P_ii) too, n_x x N.
MatrixXd run_ekf(const FilterPlant& plant, const FilterConfig& config, const MatrixXd& outputs, const MatrixXd& inputs,
                 const VectorXd& time_s, MatrixXd* deviations = nullptr) {
  const Index nx = config.initial_state.size();
  const MatrixXd identity = MatrixXd::Identity(nx, nx), r = output_covariance(config, outputs.rows());
  VectorXd x = config.initial_state;
  MatrixXd p = config.initial_covariance, estimates(nx, outputs.cols());
  for (Index k = 0; k < outputs.cols(); ++k) {
    const HeldInputs u = inputs_of_step(config, inputs, k);
    if (k > 0) {
      const Stencil stencil(x);
      const double h = time_s[k] - time_s[k - 1];
      const MatrixXd next = advance(plant, stencil.points, h, u.from, u.to);
      const MatrixXd j = stencil.jacobian(next);
      x = next.col(0);
      p = j * p * j.transpose() + process_covariance(config, h);
    }
    const Stencil stencil(x);
    const MatrixXd predicted = output_at(plant, stencil.points, u.to);
    const MatrixXd h = stencil.jacobian(predicted);
    const MatrixXd gain =
        codegen::solve_symmetric(h * p * h.transpose() + r, h * p).transpose();  // P H' S^-1, S and P symmetric
    MatrixXd innovation = outputs.col(k) - predicted.col(0);
    wrap_outputs(plant, innovation);
    x += gain * innovation;
    const MatrixXd kept = identity - gain * h;
    p = kept * p * kept.transpose() + gain * r * gain.transpose();
    restart_if_lost(config, x, p);
    estimates.col(k) = x;
    if (deviations != nullptr) deviations->col(k) = p.diagonal().cwiseMax(0.0).cwiseSqrt();
  }
  return estimates;
}

}  // namespace

IntervalEstimatorFactory ekf_intervals(std::function<FilterPlant()> make_plant, const FilterConfig& config) {
  return [make_plant = std::move(make_plant), config]() -> IntervalEstimator {
    return [plant = make_plant(), config](const MatrixXd& outputs, const MatrixXd& inputs, const VectorXd& time_s) {
      constexpr double kNormal68 = 0.994457883209753, kNormal95 = 1.959963984540054;
      MatrixXd deviations(config.initial_state.size(), outputs.cols());
      MatrixXd x_hat = run_ekf(plant, config, outputs, inputs, time_s, &deviations);
      return IntervalEstimates{std::move(x_hat), kNormal68 * deviations, kNormal95 * deviations};
    };
  };
}

FilterConfig ekf_config(const VectorXd& low, const VectorXd& high, const NoiseConfig& noise) {
  const VectorXd variance = (high - low).cwiseAbs2() / 12.0;
  return {0.5 * (low + high), MatrixXd(variance.asDiagonal()), 1e-6, noise_variances(noise)};
}

EstimatorFactory ekf_estimator(std::function<FilterPlant()> make_plant, const FilterConfig& config) {
  return [make_plant = std::move(make_plant), config]() -> Estimator {
    return [plant = make_plant(), config](const MatrixXd& outputs, const MatrixXd& inputs, const VectorXd& time_s) {
      return run_ekf(plant, config, outputs, inputs, time_s);
    };
  };
}

}  // namespace nlo::trainer
