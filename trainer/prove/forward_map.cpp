// SPDX-License-Identifier: MIT
#include "trainer/prove/forward_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "codegen/base/error.h"
#include "codegen/base/linear_algebra.h"
#include "trainer/plants/simulate.h"

namespace nlo::trainer {
namespace {

using Complex = std::complex<double>;

/// Returns the integral over s in [0, h] of exp(lambda s) s^j ds / h^j by its power series, which has no cancellation
/// for slow modes. |lambda h| <= 1/2 needs about twelve terms.
Complex moment(Complex lambda, double h, int j) {
  Complex sum = 0.0, term = h;
  for (int n = 0; n < 40; ++n) {
    sum += term / static_cast<double>(n + j + 1);
    term *= lambda * h / static_cast<double>(n + 1);
  }
  return sum;
}

/// Weights of y(0), y(h/2), y(h) in the integral of exp(lambda s) y(s) over [0, h], where y is approximated by a
/// parabola.
struct Weights {
  Complex decay, first, middle, last;
};

Weights weights(Complex lambda, double h) {
  const Complex m0 = moment(lambda, h, 0), m1 = moment(lambda, h, 1), m2 = moment(lambda, h, 2);
  return {std::exp(lambda * h), m0 - 3.0 * m1 + 2.0 * m2, 4.0 * (m1 - m2), 2.0 * m2 - m1};
}

/// Returns 1 for r <= inner, 0 for r >= outer, and a twice continuously differentiable function in between.
double smooth_switch(double r, double inner, double outer) {
  const double t = std::clamp((outer - r) / (outer - inner), 0.0, 1.0);
  return t * t * t * (t * (6.0 * t - 15.0) + 10.0);
}

}  // namespace

MapDomain domain_around(const Eigen::MatrixXd& states) {
  const Eigen::VectorXd low = states.rowwise().minCoeff(), high = states.rowwise().maxCoeff();
  const Eigen::VectorXd half = 0.5 * (high - low);
  const double widest = std::max(half.maxCoeff(), 1e-9);
  return {0.5 * (low + high), half.cwiseMax(1e-3 * widest)};
}

/// The plant chi(x) f(x). It equals the plant inside O and is at rest far outside of O.
class ForwardMap::Switched final : public Plant {
 public:
  Switched(const Plant& plant, const MapDomain& domain)
      : Plant(plant.name(), plant.states(), plant.outputs()), plant_(plant), domain_(domain) {}

  Eigen::MatrixXd derivative(const Eigen::MatrixXd& x) const override {
    Eigen::MatrixXd dx = plant_.derivative(x);
    for (Eigen::Index b = 0; b < x.cols(); ++b) {
      double chi = 1.0;
      for (Eigen::Index i = 0; i < x.rows(); ++i)
        chi *=
            smooth_switch(std::abs(x(i, b) - domain_.centre(i)) / domain_.half_width(i), domain_.inner, domain_.outer);
      if (chi == 0.0) {
        dx.col(b).setZero();  // also if f is NaN there
      } else if (chi < 1.0) {
        dx.col(b) *= chi;
      }
    }
    return dx;
  }

  Eigen::MatrixXd output(const Eigen::MatrixXd& x) const override { return plant_.output(x); }

 private:
  const Plant& plant_;
  const MapDomain& domain_;
};

ForwardMap::ForwardMap(const Plant& plant, LatentSystem system, MapDomain domain, ForwardMapOptions options)
    : plant_(plant),
      system_(std::move(system)),
      modes_(modes_of(system_)),
      domain_(std::move(domain)),
      options_(options) {
  switched_ = std::make_unique<Switched>(plant_, domain_);
}

ForwardMap::~ForwardMap() = default;

double ForwardMap::step_s() const {
  return std::min(options_.longest_step_s, options_.step_per_time / fastest(system_));
}

Eigen::MatrixXd ForwardMap::at(const Eigen::MatrixXd& x) const {
  const double h = step_s();
  const auto count = static_cast<Eigen::Index>(modes_.size());
  std::vector<Weights> weight;
  for (const LatentMode& mode : modes_) weight.push_back(weights(mode.lambda, h));
  const double horizon_s = std::log(options_.truncation) / slowest(system_, true);

  Eigen::MatrixXcd z = Eigen::MatrixXcd::Zero(count, x.cols());
  std::vector<Complex> decay(modes_.size(), 1.0);
  Eigen::MatrixXd state = x, y = plant_.output(x);
  for (double past_s = 0.0; past_s < horizon_s; past_s += h) {
    state = rk4_step(*switched_, state, -0.5 * h);
    const Eigen::MatrixXd y_middle = plant_.output(state);
    state = rk4_step(*switched_, state, -0.5 * h);
    const Eigen::MatrixXd y_last = plant_.output(state);
    for (std::size_t i = 0; i < modes_.size(); ++i) {
      if (!modes_[i].driven || std::abs(decay[i]) < options_.truncation) continue;
      const Weights& w = weight[i];
      z.row(static_cast<Eigen::Index>(i)) +=
          decay[i] * (modes_[i].f * (w.first * y + w.middle * y_middle + w.last * y_last));
      decay[i] *= w.decay;
    }
    y = y_last;
  }
  for (std::size_t i = 0; i < modes_.size(); ++i)
    if (modes_[i].driven) z.row(static_cast<Eigen::Index>(i)) -= decay[i] / modes_[i].lambda * (modes_[i].f * y);
  return real_rows(modes_, z);
}

std::vector<Eigen::MatrixXd> ForwardMap::jacobians(const Eigen::MatrixXd& x, double step) const {
  const Eigen::Index nx = x.rows(), count = x.cols();
  const Eigen::VectorXd epsilon = (step > 0.0 ? step : options_.difference_step) * domain_.half_width;
  Eigen::MatrixXd around(nx, 2 * nx * count);  // for each state: all points shifted up, then all points shifted down
  for (Eigen::Index i = 0; i < nx; ++i) {
    for (const int side : {0, 1}) {
      auto moved = around.middleCols((2 * i + side) * count, count);
      moved = x;
      moved.row(i).array() += (side == 0 ? 1.0 : -1.0) * epsilon(i);
    }
  }
  const Eigen::MatrixXd z = at(around);
  std::vector<Eigen::MatrixXd> result(static_cast<std::size_t>(count), Eigen::MatrixXd(system_.nz(), nx));
  for (Eigen::Index i = 0; i < nx; ++i) {
    const Eigen::MatrixXd slope =
        (z.middleCols(2 * i * count, count) - z.middleCols((2 * i + 1) * count, count)) / (2.0 * epsilon(i));
    for (Eigen::Index b = 0; b < count; ++b) result[static_cast<std::size_t>(b)].col(i) = slope.col(b);
  }
  return result;
}

ForwardMap::Path ForwardMap::along(const Eigen::MatrixXd& initial, double sample_period_s, Eigen::Index samples) const {
  const auto parts = static_cast<int>(std::ceil(sample_period_s / step_s()));
  const double h = sample_period_s / parts;
  std::vector<Weights> weight;
  for (const LatentMode& mode : modes_) weight.push_back(weights(mode.lambda, h));

  const Eigen::MatrixXd start = at(initial);
  Eigen::MatrixXcd z(static_cast<Eigen::Index>(modes_.size()), initial.cols());
  for (std::size_t i = 0; i < modes_.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    z.row(row) = start.row(modes_[i].row).cast<Complex>();
    if (modes_[i].rows == 2) z.row(row) += Complex(0.0, 1.0) * start.row(modes_[i].row + 1);
  }
  Path path;
  Eigen::MatrixXd state = initial, y = plant_.output(initial);
  for (Eigen::Index k = 0;; ++k) {
    path.x.push_back(state);
    path.z.push_back(real_rows(modes_, z));
    if (k + 1 >= samples) return path;
    for (int part = 0; part < parts; ++part) {
      state = rk4_step(plant_, state, 0.5 * h);
      const Eigen::MatrixXd y_middle = plant_.output(state);
      state = rk4_step(plant_, state, 0.5 * h);
      const Eigen::MatrixXd y_last = plant_.output(state);
      for (std::size_t i = 0; i < modes_.size(); ++i) {
        // The integral runs backwards in time: the latest output is at s = 0.
        const Weights& w = weight[i];
        const auto row = static_cast<Eigen::Index>(i);
        z.row(row) = w.decay * z.row(row) + modes_[i].f * (w.first * y_last + w.middle * y_middle + w.last * y);
      }
      y = y_last;
    }
  }
}

Eigen::VectorXd ForwardMap::pde_residual(const Eigen::MatrixXd& x) const {
  // Computes dT/dx f as one difference along f, scaled so that no state moves by more than the difference step.
  const Eigen::MatrixXd f = plant_.derivative(x);
  const Eigen::RowVectorXd speed =
      (f.array().colwise() / domain_.half_width.array()).abs().colwise().maxCoeff().max(1e-9);
  const Eigen::RowVectorXd step = options_.difference_step * speed.cwiseInverse();
  const Eigen::MatrixXd move = f * step.asDiagonal();
  Eigen::MatrixXd all(x.rows(), 3 * x.cols());
  all << x + move, x - move, x;
  const Eigen::MatrixXd z = at(all);
  const Eigen::Index n = x.cols();
  const Eigen::MatrixXd along_f = (z.leftCols(n) - z.middleCols(n, n)) * (2.0 * step).cwiseInverse().asDiagonal();
  return (along_f - apply_d(system_, z.rightCols(n)) - system_.injection * plant_.output(x)).colwise().norm();
}

Eigen::MatrixXd sylvester_map(const Eigen::MatrixXd& a, const Eigen::MatrixXd& c, const LatentSystem& system) {
  constexpr double kSingular = 1e-10;  // smallest / largest singular value; below it, rounding errors dominate T
  const std::vector<LatentMode> modes = modes_of(system);
  Eigen::MatrixXcd t = Eigen::MatrixXcd::Zero(static_cast<Eigen::Index>(modes.size()), a.cols());
  for (std::size_t i = 0; i < modes.size(); ++i) {
    if (!modes[i].driven) continue;
    Eigen::MatrixXcd shifted = a.cast<Complex>();
    shifted.diagonal().array() -= modes[i].lambda;
    const Eigen::VectorXd sigma = codegen::singular_values(shifted);
    if (sigma(sigma.size() - 1) <= kSingular * sigma(0))
      throw codegen::Error(
          fmt::format("the eigenvalue {:.6g}{:+.6g}i of D is an eigenvalue of the plant, so no map T exists; choose "
                      "another factor k",
                      modes[i].lambda.real(), modes[i].lambda.imag()));
    t.row(static_cast<Eigen::Index>(i)) = modes[i].f * c * codegen::inverse(shifted);
  }
  return real_rows(modes, t);
}

}  // namespace nlo::trainer
