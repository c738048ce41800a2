// SPDX-License-Identifier: MIT
// The equations of codegen/model/prior.h, with dynamic sizes and nothing folded.
#pragma once

#include <nlo/explicit_rk.h>

#include <cmath>

#include "codegen/model/prior.h"
#include "codegen/structures/gated_units.h"
#include "codegen/structures/module.h"

namespace nlo::codegen {

inline Equations prior_equations(const Model& m) {
  return {own_part<Prior>(m).equations, m.states, m.inputs};
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
        equations_(prior_equations(m)),
        units_(own_.gates, own_.candidate, activations),
        correction_(own_.correction, activations) {}

  void start(Matrix& z, const Matrix& y) const override { correct(z, y, Scalar(1)); }

  void advance(Vector& z, const Between<Scalar>& over, double dt_s) override {
    const int pieces = pieces_of(dt_s, sample_period_s_);
    const auto h = static_cast<Scalar>(dt_s / pieces), share = Scalar(1) / static_cast<Scalar>(pieces);
    const Eigen::Index nx = equations_.nx();
    Vector x = z.tail(nx);
    for (int i = 0; i < pieces; ++i) {
      equations_.step(x.data(), h, [&](double c, Scalar* u) {
        const Scalar part = (static_cast<Scalar>(i) + static_cast<Scalar>(c)) * share;
        for (Eigen::Index j = 0; j < inputs_; ++j)
          u[j] = (1 - part) * over.y(equations_.ny() + j) + part * over.y_next(equations_.ny() + j);
      });
      keep_within(x);
    }
    z.tail(nx) = x;
    Matrix all = z;
    correct(all, over.y_next, static_cast<Scalar>(dt_s / sample_period_s_));
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

  /// z = [m; x-] becomes [m; x], column by column.
  void correct(Matrix& z, const Matrix& readings, Scalar periods) const {
    const Eigen::Index nx = equations_.nx(), ny = equations_.ny(), units = z.rows() - nx;
    Matrix w(2 * ny + readings.rows() + nx, z.cols());
    w << Matrix::Zero(2 * ny, z.cols()), readings, z.bottomRows(nx);
    for (Eigen::Index b = 0; b < z.cols(); ++b) {
      const Vector x = z.col(b).tail(nx);
      Vector expected(ny);
      equations_.output(x.data(), expected.data());
      for (Eigen::Index j = 0; j < ny; ++j) {
        const Scalar nu = readings(j, b) - expected(j);
        w(j, b) = nu / (static_cast<Scalar>(own_.fine(j)) + std::abs(nu));
        w(ny + j, b) = nu / (static_cast<Scalar>(own_.coarse(j)) + std::abs(nu));
      }
    }
    const Matrix m = units_.stepped(z.topRows(units), w, periods), gain = correction_(stacked<Scalar>(m, w));
    z.topRows(units) = m;
    for (Eigen::Index b = 0; b < z.cols(); ++b) {
      Vector x = z.col(b).tail(nx);
      for (Eigen::Index i = 0; i < nx; ++i) {
        Scalar change = gain(nx * ny + i, b);
        for (Eigen::Index j = 0; j < ny; ++j) change += gain(i * ny + j, b) * w(ny + j, b);
        x(i) += change;
      }
      keep_within(x);
      z.col(b).tail(nx) = x;
    }
  }

  double sample_period_s_;
  Eigen::Index inputs_;
  Prior own_;
  Equations equations_;
  ReferenceUnits<Scalar> units_;
  ReferenceNetwork<Scalar> correction_;
};

}  // namespace nlo::codegen
