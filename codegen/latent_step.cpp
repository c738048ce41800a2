// SPDX-License-Identifier: MIT
#include "codegen/latent_step.h"

#include <nlo/latent.h>

namespace nlo::codegen {
namespace {

Hold hold_of(const Model& m, double dt_s) {
  if (m.hold == "zero_order") return Hold::kZeroOrder;
  if (m.hold == "rk4" && dt_s == m.sample_period_s) return Hold::kRk4;
  return Hold::kFirstOrder;
}

}  // namespace

LatentStep latent_step(const Model& m, double dt_s) {
  const Hold hold = hold_of(m, dt_s);
  const Eigen::MatrixXd& f = m.output_injection;
  LatentStep step{Eigen::VectorXd(m.nz()), Eigen::MatrixXd(m.nz(), m.ny()), Eigen::MatrixXd(m.nz(), m.ny())};
  for (int r = 0; r < 2 * m.pairs; r += 2) {
    const auto mode = discretise(hold, Complex<double>{m.eigenvalues(r), m.eigenvalues(r + 1)}, dt_s);
    step.a_minus_1.segment<2>(r) << mode.a_minus_1.re, mode.a_minus_1.im;
    step.b0.row(r) = mode.b0.re * f.row(r) - mode.b0.im * f.row(r + 1);
    step.b0.row(r + 1) = mode.b0.im * f.row(r) + mode.b0.re * f.row(r + 1);
    step.b1.row(r) = mode.b1.re * f.row(r) - mode.b1.im * f.row(r + 1);
    step.b1.row(r + 1) = mode.b1.im * f.row(r) + mode.b1.re * f.row(r + 1);
  }
  for (int r = 2 * m.pairs; r < m.nz(); ++r) {
    const auto mode = discretise(hold, Complex<double>{m.eigenvalues(r), 0.0}, dt_s);
    step.a_minus_1(r) = mode.a_minus_1.re;
    step.b0.row(r) = mode.b0.re * f.row(r);
    step.b1.row(r) = mode.b1.re * f.row(r);
  }
  return step;
}

Eigen::MatrixXd a_minus_identity(const Model& m, const LatentStep& step) {
  Eigen::MatrixXd matrix = step.a_minus_1.asDiagonal();
  for (int r = 0; r < 2 * m.pairs; r += 2) {
    const double re = step.a_minus_1(r), im = step.a_minus_1(r + 1);
    matrix.block<2, 2>(r, r) << re, -im, im, re;
  }
  return matrix;
}

}  // namespace nlo::codegen
