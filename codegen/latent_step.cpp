// SPDX-License-Identifier: MIT
#include "codegen/latent_step.h"

#include <nlo/latent.h>

namespace nlo::codegen {
namespace {

LatentStep discretised(const Model& m, Hold hold, double dt_s) {
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

}  // namespace

Hold hold_named(const std::string& name) {
  return name == "zero_order" ? Hold::kZeroOrder : name == "rk4" ? Hold::kRk4 : Hold::kFirstOrder;
}

LatentStep latent_step(const Model& m, double dt_s) {
  const Hold hold = hold_named(m.hold);
  const bool exact = hold == Hold::kRk4 && dt_s != m.sample_period_s;
  return discretised(m, exact ? Hold::kFirstOrder : hold, dt_s);
}

ForcedLatentStep forced_latent_step(const Model& m, double dt_s) {
  const Hold hold = hold_named(m.hold);
  ForcedLatentStep step{discretised(m, hold == Hold::kRk4 ? Hold::kFirstOrder : hold, 0.5 * dt_s), {}};
  for (int r = 0; r < m.nz(); ++r) {
    const bool paired = r < 2 * m.pairs;
    const auto mode = forced_weights(Complex<double>{m.eigenvalues(r), paired ? m.eigenvalues(r + 1) : 0.0}, dt_s);
    const auto set = [&](Eigen::VectorXd& weights, const Complex<double>& value) {
      weights.conservativeResize(m.nz());
      weights(r) = value.re;
      if (paired) weights(r + 1) = value.im;
    };
    auto& w = step.weights;
    set(w.stage2, mode.stage2);
    set(w.stage3_1, mode.stage3_1);
    set(w.stage3_2, mode.stage3_2);
    set(w.stage4_1, mode.stage4_1);
    set(w.stage4_3, mode.stage4_3);
    set(w.end_1, mode.end_1);
    set(w.end_23, mode.end_23);
    set(w.end_4, mode.end_4);
    if (paired) ++r;
  }
  return step;
}

Eigen::MatrixXd block_diagonal(const Model& m, const Eigen::VectorXd& modes) {
  Eigen::MatrixXd matrix = modes.asDiagonal();
  for (int r = 0; r < 2 * m.pairs; r += 2) {
    const double re = modes(r), im = modes(r + 1);
    matrix.block<2, 2>(r, r) << re, -im, im, re;
  }
  return matrix;
}

Eigen::MatrixXd steady_gain(const Model& m) {
  Eigen::MatrixXd gain(m.output_injection.rows(), m.output_injection.cols());
  for (int p = 0; p < m.pairs; ++p) {
    const double re = m.eigenvalues(2 * p), im = m.eigenvalues(2 * p + 1), square = re * re + im * im;
    const auto f_re = m.output_injection.row(2 * p), f_im = m.output_injection.row(2 * p + 1);
    gain.row(2 * p) = -(re * f_re + im * f_im) / square;
    gain.row(2 * p + 1) = -(re * f_im - im * f_re) / square;
  }
  for (Eigen::Index i = 2 * m.pairs; i < m.eigenvalues.size(); ++i)
    gain.row(i) = -m.output_injection.row(i) / m.eigenvalues(i);
  return gain.array() + 0.0;  // -0 becomes 0
}

}  // namespace nlo::codegen
