// SPDX-License-Identifier: MIT
#include "trainer/prove/robustness_bound.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "trainer/prove/lipschitz.h"

namespace nlo::trainer {
namespace {

template <class Matrix>
double box_image_norm(const Matrix& f, const Eigen::VectorXd& v) {
  constexpr Eigen::Index kMostCorners = 16;
  const Eigen::Index ny = v.size();
  if (ny == 0) return 0.0;
  if (ny > kMostCorners) return (f.colwise().norm() * v).value();
  double largest = 0.0;
  Eigen::VectorXd corner = v;
  for (unsigned signs = 0; signs < (1u << (ny - 1)); ++signs) {  // -v has the norm of v
    for (Eigen::Index j = 0; j + 1 < ny; ++j) corner(j) = (signs >> j & 1u) != 0 ? -v(j) : v(j);
    largest = std::max(largest, (f * corner).norm());
  }
  return largest;
}

}  // namespace

double ErrorBound::at(double t_s, double initial_latent_error) const {
  return gain * std::exp(rate * t_s) * initial_latent_error + steady;
}

double ErrorBound::transient_s(double initial_latent_error, double level) const {
  const double start = gain * initial_latent_error, room = level - steady;
  if (start <= room) return 0.0;
  return room > 0.0 ? std::log(room / start) / rate : std::numeric_limits<double>::infinity();
}

ErrorBound bound_19(const Proposition2& p, double k, double w_bar, double v_bar) {
  const double rate = k * p.lambda_max;
  const double gain = std::pow(k, static_cast<double>(p.nz)) * std::sqrt(static_cast<double>(p.nx)) * p.l_t;
  // L_Tx may be infinite; without a disturbance it must have no effect.
  const double disturbed = w_bar == 0.0 ? 0.0 : p.l_tx / k * w_bar;
  return {gain, rate, gain / std::abs(rate) * (disturbed + v_bar)};
}

double injected_bound(const Eigen::MatrixXd& injection, const Eigen::VectorXd& v) {
  return box_image_norm(injection, v);
}

double injected_bound(const LatentMode& mode, const Eigen::VectorXd& v) {
  Eigen::MatrixXd f(2, mode.f.size());
  f << mode.f.real(), mode.f.imag();
  return box_image_norm(f, v);
}

void widen_row_slopes(const std::vector<LatentMode>& modes, const Eigen::MatrixXd& dt_dx, Eigen::VectorXd& largest) {
  if (largest.size() == 0) largest = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(modes.size()));
  for (std::size_t i = 0; i < modes.size(); ++i) {
    double& slope = largest(static_cast<Eigen::Index>(i));
    slope = std::max(slope, spectral_norm(dt_dx.middleRows(modes[i].row, modes[i].rows)));
  }
}

double steady_latent_error(const LatentSystem& system, const Eigen::VectorXd& v, double w_bar,
                           const Eigen::VectorXd& row_slopes) {
  const std::vector<LatentMode> modes = modes_of(system);
  double squares = 0.0;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    if (!modes[i].driven) continue;
    const double disturbed = w_bar == 0.0 ? 0.0 : row_slopes(static_cast<Eigen::Index>(i)) * w_bar;
    const double e = (injected_bound(modes[i], v) + disturbed) / std::abs(modes[i].lambda.real());
    squares += e * e;
  }
  return std::sqrt(squares);
}

}  // namespace nlo::trainer
