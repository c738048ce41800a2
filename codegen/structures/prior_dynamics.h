// SPDX-License-Identifier: MIT
// The equations of codegen/model/prior.h with dynamic sizes and without folding.
#pragma once

#include <nlo/explicit_rk.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "codegen/model/prior.h"
#include "codegen/structures/reference_units.h"
#include "codegen/structures/structure_module.h"

namespace nlo::codegen {

inline Equations prior_equations(const Model& m) {
  const EquationTexts& texts = own_part<Prior>(m).equations;
  std::vector<Channel> states = m.states;
  for (const std::string& name : texts.unestimated) states.push_back({name, ""});
  return {texts, states, m.inputs};
}

template <class Scalar>
class PriorDynamics final : public ReferenceDynamics<Scalar> {
 public:
  using typename ReferenceDynamics<Scalar>::Vector;
  using typename ReferenceDynamics<Scalar>::Matrix;

  PriorDynamics(const Model& m, Activations activations)
      : sample_period_s_(m.sample_period_s),
        inputs_(static_cast<Eigen::Index>(m.inputs.size())),
        own_(own_part<Prior>(m)),
        equations_(prior_equations(m)) {
    if (m.nz() == equations_.carried()) return;
    units_.emplace(own_.gates, own_.candidate, activations);
    correction_.emplace(own_.correction, activations);
  }

  void start(Matrix& z, const Matrix& y, const std::vector<bool>* arrived) const override {
    correct(z, y, arrived, Scalar(1));
  }

  void advance(Vector& z, const Between<Scalar>& over, double dt_s) override {
    const int pieces = pieces_of(dt_s, sample_period_s_);
    const auto h = static_cast<Scalar>(dt_s / pieces), share = Scalar(1) / static_cast<Scalar>(pieces);
    const Eigen::Index carried = equations_.carried();
    Vector x = z.tail(carried);
    for (int i = 0; i < pieces; ++i) {
      equations_.step(x.data(), h, [&](double c, Scalar* u) {
        const Scalar part = (static_cast<Scalar>(i) + static_cast<Scalar>(c)) * share;
        for (Eigen::Index j = 0; j < inputs_; ++j)
          u[j] = (1 - part) * over.y(equations_.ny() + j) + part * over.y_next(equations_.ny() + j);
      });
      keep_within(x);
    }
    z.tail(carried) = x;
    Matrix all = z;
    correct(all, over.y_next, over.arrived, static_cast<Scalar>(dt_s / sample_period_s_));
    z = all;
  }
  double longest_step_s() const override { return kMostPieces * sample_period_s_; }

  Matrix slope(const Matrix&, const Matrix&, const Vector&) const override {
    throw Error("an observer with a prior has no differential equation; give it sampled measurements");
  }

 private:
  void keep_within(Vector& x) const {
    for (Eigen::Index i = 0; i < x.size(); ++i) x(i) = kept_within(x(i), own_.state_min(i), own_.state_max(i));
  }

  static bool has_arrived(const std::vector<bool>* arrived, Eigen::Index j) {
    return arrived == nullptr || (*arrived)[static_cast<std::size_t>(j)];
  }

  /// The corrections of one sample: a column for each column of z.
  struct Corrections {
    Matrix state;  ///< n_s: K s(nu, coarse) + b
    Matrix noise;  ///< n_s + n_y: c_q and c_r
  };

  /// Turns z = [m; x-; p-] into [m; x; p], column by column.
  void correct(Matrix& z, const Matrix& readings, const std::vector<bool>* arrived, Scalar periods) const {
    const Eigen::Index nx = equations_.nx(), ny = equations_.ny(), carried = equations_.carried();
    Matrix nu(ny, z.cols()), expected(ny * (1 + nx), z.cols());
    for (Eigen::Index b = 0; b < z.cols(); ++b) {
      expected.col(b) = expected_at(z.col(b).tail(carried), readings.col(b));
      for (Eigen::Index j = 0; j < ny; ++j)
        nu(j, b) = has_arrived(arrived, j) ? readings(j, b) - expected(j, b) : Scalar(0);
    }
    const Corrections by = units_ ? learned(z, readings, nu, periods)
                                  : Corrections{Matrix::Zero(nx, z.cols()), Matrix::Zero(nx + ny, z.cols())};
    for (Eigen::Index b = 0; b < z.cols(); ++b) {
      Vector x = z.col(b).tail(carried);
      const Vector change = filtered(x, expected.col(b), nu.col(b), by.noise.col(b), arrived, periods);
      x.head(nx) += change + by.state.col(b);
      keep_within(x);
      z.col(b).tail(carried) = x;
    }
  }

  /// Steps the units in z = [m; x-; p-], and returns their corrections.
  Corrections learned(Matrix& z, const Matrix& readings, const Matrix& nu, Scalar periods) const {
    const Eigen::Index nx = equations_.nx(), ny = equations_.ny(), units = z.rows() - equations_.carried();
    Matrix w(2 * ny + readings.rows() + nx, z.cols());
    const auto squashed = [&nu](const Eigen::VectorXd& half) {
      return nu.binaryExpr(half.template cast<Scalar>().replicate(1, nu.cols()),
                           [](Scalar v, Scalar c) { return v / (c + std::abs(v)); });
    };
    w << squashed(own_.fine), squashed(own_.coarse), readings, z.middleRows(units, nx);
    const Matrix m = units_->stepped(z.topRows(units), w, periods), gain = (*correction_)(stacked<Scalar>(m, w));
    z.topRows(units) = m;
    Matrix state = gain.middleRows(nx * ny, nx);
    for (Eigen::Index i = 0; i < nx; ++i)
      for (Eigen::Index j = 0; j < ny; ++j) state.row(i) += gain.row(i * ny + j).cwiseProduct(w.row(ny + j));
    return {state, gain.bottomRows(nx + ny)};
  }

  /// Returns y and its slopes. readings: the measured outputs, then the inputs.
  Vector expected_at(const Vector& x, const Vector& readings) const {
    Vector expected(equations_.ny() * (1 + equations_.nx()));
    equations_.output(x.data(), readings.data() + equations_.ny(), expected.data());
    return expected;
  }

  /// Returns the correction that an extended Kalman filter's measurement adds to x, and updates the covariance in x.
  ///   expected  y and its slopes at x
  Vector filtered(Vector& x, const Vector& expected, const Vector& nu, const Vector& logarithms,
                  const std::vector<bool>* arrived, Scalar periods) const {
    const Eigen::Index nx = equations_.nx(), ny = equations_.ny();
    const auto noise = [&](const Eigen::VectorXd& unit, Eigen::Index at, Eigen::Index row) {
      return static_cast<Scalar>(unit(at)) * std::exp(std::clamp(logarithms(row), Scalar(-16), Scalar(16)));
    };
    const auto element = [&](Eigen::Index i, Eigen::Index j) -> Scalar& {
      return x(equations_.place(static_cast<int>(i), static_cast<int>(j)));
    };
    Matrix p(nx, nx);
    for (Eigen::Index i = 0; i < nx; ++i)
      for (Eigen::Index j = 0; j < nx; ++j) p(i, j) = element(i, j);
    for (Eigen::Index i = 0; i < nx; ++i) p(i, i) += periods * noise(own_.state_noise, i, i);
    Vector change = Vector::Zero(nx);
    for (Eigen::Index j = 0; j < ny; ++j) {
      if (!has_arrived(arrived, j)) continue;
      const Vector slopes = expected.segment(ny + j * nx, nx), ph = p * slopes;
      const Scalar spread =
          (1 + Scalar(kLeastNoise)) * std::max(slopes.dot(ph), Scalar(0)) + noise(own_.output_noise, j, nx + j);
      const Scalar rest = nu(j) - slopes.dot(change);
      change += ph * (rest / spread);
      p -= ph * ph.transpose() / spread;
    }
    for (Eigen::Index i = 0; i < nx; ++i)
      for (Eigen::Index j = i; j < nx; ++j) element(i, j) = p(i, j);
    return change;
  }

  double sample_period_s_;
  Eigen::Index inputs_;
  Prior own_;
  Equations equations_;
  std::optional<ReferenceUnits<Scalar>> units_;  ///< none in a filter without units
  std::optional<ReferenceNetwork<Scalar>> correction_;
};

}  // namespace nlo::codegen
