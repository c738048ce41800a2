// SPDX-License-Identifier: MIT
#include "trainer/baselines/ekf.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "codegen/base/linear_algebra.h"
#include "codegen/reference/rk4.h"
#include "trainer/data/angle.h"
#include "trainer/evaluation/measurement_noise.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kLeastOutputVariance = 1e-4;

/// `u0`, `u1`: the inputs at both ends of the step; empty when nothing excites the plant.
MatrixXd rk4(const EkfPlant& plant, const MatrixXd& x, double h, const VectorXd& u0, const VectorXd& u1) {
  const auto f = [&](const MatrixXd& at, const VectorXd& u) {
    return plant.driven && u.size() > 0 ? plant.driven(at, u) : plant.f(at);
  };
  const VectorXd middle = 0.5 * (u0 + u1);
  return codegen::rk4_step(x, h, [&](double c, const MatrixXd& at) {
    return f(at, c == 0.0 ? u0 : c == 1.0 ? u1 : middle);
  });
}

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

MatrixXd run_ekf(const EkfPlant& plant, const EkfConfig& config, const MatrixXd& outputs, const MatrixXd& inputs,
                 const VectorXd& time_s) {
  const Index nx = config.initial_state.size(), ny = outputs.rows();
  const MatrixXd identity = MatrixXd::Identity(nx, nx);
  const MatrixXd q = config.process_variance * identity;
  VectorXd variance = config.output_variance.cwiseMax(kLeastOutputVariance);
  if (variance.size() == 1) variance = VectorXd::Constant(ny, variance[0]);
  const MatrixXd r = variance.asDiagonal();

  VectorXd x = config.initial_state;
  MatrixXd p = config.initial_covariance, estimates(nx, outputs.cols());
  for (Index k = 0; k < outputs.cols(); ++k) {
    if (k > 0) {
      const Stencil stencil(x);
      const bool excited = inputs.cols() > 0;
      const double h = time_s[k] - time_s[k - 1];
      const Index before = config.held_inputs ? k : k - 1;
      const MatrixXd next = rk4(plant, stencil.points, h, excited ? VectorXd(inputs.col(before)) : VectorXd(),
                                excited ? VectorXd(inputs.col(k)) : VectorXd());
      const MatrixXd j = stencil.jacobian(next);
      x = next.col(0);
      p = j * p * j.transpose() + q;
      if (config.process_noise.size() > 0) p.diagonal() += h * config.process_noise.cwiseAbs2();
    }
    const Stencil stencil(x);
    const MatrixXd predicted = plant.h(stencil.points);
    const MatrixXd h = stencil.jacobian(predicted);
    const MatrixXd gain =
        codegen::solve_symmetric(h * p * h.transpose() + r, h * p).transpose();  // P H' S^-1, S and P symmetric
    VectorXd innovation = outputs.col(k) - predicted.col(0);
    for (Index j = 0; j < plant.output_wraps.size(); ++j)
      if (plant.output_wraps[j] > 0.0) innovation[j] = wrap_difference(innovation[j], plant.output_wraps[j]);
    x += gain * innovation;
    const MatrixXd kept = identity - gain * h;
    p = kept * p * kept.transpose() + gain * r * gain.transpose();
    estimates.col(k) = x;
  }
  return estimates;
}

}  // namespace

EkfConfig ekf_config(const VectorXd& low, const VectorXd& high, const NoiseConfig& noise) {
  const VectorXd variance = (high - low).cwiseAbs2() / 12.0;
  return {0.5 * (low + high), MatrixXd(variance.asDiagonal()), 1e-6, noise_variances(noise)};
}

EstimatorFactory ekf_estimator(std::function<EkfPlant()> make_plant, const EkfConfig& config) {
  return [make_plant = std::move(make_plant), config]() -> Estimator {
    return [plant = make_plant(), config](const MatrixXd& outputs, const MatrixXd& inputs, const VectorXd& time_s) {
      return run_ekf(plant, config, outputs, inputs, time_s);
    };
  };
}

}  // namespace nlo::trainer
